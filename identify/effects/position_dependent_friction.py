"""Dry friction that changes along a turn of the joint: an eccentric gear or a bent bearing."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import JointEffect, Parameter, shape
from .joint_state import JointState, Scalar
from .smooth_sign import smooth_sign, smooth_sign_by_reversal


@dataclass(frozen=True)
class PositionDependentFriction(JointEffect):
    r"""Torque :math:`\tanh(\dot q / v_r) (F_{cos} \cos kq + F_{sin} \sin kq)`.

    Attributes:
        harmonic: Periods per turn of the joint :math:`k` [-]; for a prismatic joint, periods per :math:`2\pi`
            meters. It is part of the parameters' names, so that several can be in one model.
        count: Number of its multiples, from the first; a tight spot has many.
        reversal: Velocity :math:`v_r` over which the sign changes [rad/s].
    """

    harmonic: float = 1
    count: int = 1
    reversal: float = shape(0.003, "rad/s", 1e-4, 0.1)

    def parameters(self, robot: Robot) -> list[Parameter]:
        numbers = [k * self.harmonic for k in range(1, self.count + 1)]
        return self.on_each(robot, *((f"F{wave}{k:g}_", "N m") for k in numbers for wave in ("cos", "sin")))

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self._waves(robot, motion, smooth_sign(motion.velocity, self.reversal))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        slope = smooth_sign_by_reversal(motion.velocity, self.reversal)
        return {"reversal": self._waves(robot, motion, slope)}

    def joint_torque(self, robot: Robot, values: np.ndarray, state: JointState) -> Sequence[Scalar]:
        def waves(joint: int) -> Sequence[Scalar]:
            sign, angle = (
                smooth_sign(state.velocity[joint], self.reversal),
                self.harmonic * state.position[joint],
            )
            return [sign * wave(k * angle) for k in range(1, self.count + 1) for wave in (np.cos, np.sin)]

        return self.on_scalars(robot, values, waves)

    def _waves(self, robot: Robot, motion: Motion, profile: np.ndarray) -> np.ndarray:
        """Regressor of a profile (t, n) multiplied by the waves along the joint."""
        angle = self.harmonic * motion.position
        waves = [wave(k * angle) for k in range(1, self.count + 1) for wave in (np.cos, np.sin)]
        return self.on_joints(robot, *[profile * wave for wave in waves])
