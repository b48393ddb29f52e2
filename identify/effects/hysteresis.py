"""Dry friction that builds up over a displacement instead of turning with the velocity's sign."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import JointEffect, shape


@dataclass(frozen=True)
class Hysteresis(JointEffect):
    r"""Torque :math:`F_h z`, with :math:`dz = (1 - z\, \mathrm{sgn}\, dq)\, dq / \delta` (Dahl 1968).

    Teeth, seals and grease first deform, then slide: after a reversal, the torque builds up over a
    displacement, at any speed. In steady sliding it equals Coulomb friction of the same size, which it
    replaces in a model.

    Attributes:
        presliding: Displacement :math:`\delta` over which 63 % of the change is made [rad].
    """

    presliding: float = shape(3e-4, "rad", 1e-5, 3e-2)

    pointwise: ClassVar[bool] = False
    coefficients: ClassVar[tuple[tuple[Any, ...], ...]] = (("Fh", "N m", 0.0),)

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, self._state(robot, motion)[0])

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        return {"presliding": self.on_joints(robot, self._state(robot, motion)[1])}

    def continued(self, robot: Robot, motion: Motion, memory: Any) -> tuple[np.ndarray, Any]:
        at, state = (motion.position[0], np.zeros(robot.dof)) if memory is None else memory
        states = np.empty_like(motion.position)
        for row, position in enumerate(motion.position):
            displacement = position - at  # without reversal
            sign = np.sign(displacement)
            at, state = position, sign - (sign - state) * np.exp(-np.abs(displacement) / self.presliding)
            states[row] = state
        return self.on_joints(robot, states), (at.copy(), state)

    def _state(self, robot: Robot, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
        """State z and its derivative with respect to `presliding`, each (t, n); zero on other joints."""
        state, slope = np.zeros((2, *motion.position.shape))
        for joint in self.columns(robot):
            state[:, joint], slope[:, joint] = _dahl(motion.position[:, joint], self.presliding)
        return state, slope


def _dahl(position: np.ndarray, presliding: float) -> tuple[np.ndarray, np.ndarray]:
    """State z and dz/d(presliding) along one joint's path, from z = 0.

    Between reversals, z converges exponentially along the path to the sign of the motion, so each stretch is
    one closed-form step, regardless of the number of samples.
    """
    steps = np.diff(position, prepend=position[0])
    signs = np.sign(steps)
    starts = np.concatenate([[0], np.flatnonzero(signs[1:] != signs[:-1]) + 1, [len(position)]])
    path = np.cumsum(np.abs(steps))
    stretch = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    origin = np.concatenate([[0.0], path[starts[1:-1] - 1]])
    sign = signs[starts[:-1]]
    gone, end = path - origin[stretch], path[starts[1:] - 1] - origin
    z, dz = _starts(sign, end / presliding, end / presliding**2)
    decay = np.where(signs, np.exp(-gone / presliding), 1.0)  # 1 at standstill
    gap = signs - z[stretch]
    state = np.where(signs, signs - gap * decay, z[stretch])
    slope = dz[stretch] * decay - np.where(signs, gap * decay * gone / presliding**2, 0.0)
    return state, slope


def _starts(sign: np.ndarray, length: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """State z and its derivative at the start of each stretch; `length` is in units of presliding."""
    z, dz = np.zeros((2, len(sign)))
    decay = np.exp(-length)
    for k in range(len(sign) - 1):
        if not sign[k]:
            z[k + 1], dz[k + 1] = z[k], dz[k]
            continue
        gap = (sign[k] - z[k]) * decay[k]
        z[k + 1], dz[k + 1] = sign[k] - gap, dz[k] * decay[k] - gap * rate[k]
    return z, dz
