"""Torque in waves along a turn: cogging of the motor, and friction of an eccentric gear."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import Effect, JointEffect, MotionGradient, Parameter, shape
from .joint_state import JointState, Scalar
from .smooth_sign import smooth_sign, smooth_sign_by_reversal


def _parameters(
    effect: "TorqueRipple | PositionDependentFriction", robot: Robot, letter: str
) -> list[Parameter]:
    numbers = [k * effect.harmonic for k in range(1, effect.count + 1)]
    waves = ((f"{letter}{wave}{k:g}_", "N m") for k in numbers for wave in ("cos", "sin"))
    return effect.on_each(robot, *waves)


def _waves(angle: Scalar, count: int) -> list[Scalar]:
    """Cosine and sine of an angle and of its multiples [rad]."""
    return [wave(k * angle) for k in range(1, count + 1) for wave in (np.cos, np.sin)]


@dataclass(frozen=True)
class TorqueRipple(JointEffect):
    r"""Torque :math:`R_{cos} \cos(k N q) + R_{sin} \sin(k N q)` with gear ratio :math:`N`.

    If other joints also turn this motor, the paper's (22), its angle is :math:`N C q` instead of :math:`N q`,
    and its torque acts on them through :math:`C^T`.

    Attributes:
        harmonic: Periods per turn of the motor :math:`k` [-]; part of the parameters' names, so that
            several can be in one model.
        count: Number of its multiples, from the first.
    """

    harmonic: float = 1
    count: int = 1

    def parameters(self, robot: Robot) -> list[Parameter]:
        return _parameters(self, robot, "R")

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        joints = self.columns(robot)
        angle = self.harmonic * robot.gear_ratio * (motion.position @ robot.coupling.T)
        waves = np.zeros((2 * self.count, *angle.shape))
        waves[:, :, joints] = _waves(angle[:, joints], self.count)
        on_motors = self.on_joints(robot, *waves)
        if np.array_equal(robot.coupling, np.eye(robot.dof)):
            return on_motors
        return np.einsum("mj,tmp->tjp", robot.coupling, on_motors)

    def joint_torque(self, robot: Robot, values: np.ndarray, state: JointState) -> Sequence[Scalar]:
        def waves(motor: int) -> Sequence[Scalar]:
            turned = sum(float(c) * q for c, q in zip(robot.coupling[motor], state.position, strict=True))
            angle = self.harmonic * float(robot.gear_ratio[motor]) * turned
            return _waves(angle, self.count)

        on_motors = self.on_scalars(robot, values, waves)
        return [
            sum(float(c) * f for c, f in zip(column, on_motors, strict=True)) for column in robot.coupling.T
        ]

    def motion_gradient(
        self, robot: Robot, motion: Motion, weights: np.ndarray, known: np.ndarray
    ) -> MotionGradient:
        # with coupling, the angle of a motor depends on several joints
        return Effect.motion_gradient(self, robot, motion, weights, known)


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
        return _parameters(self, robot, "F")

    def profiles(self, at: Any) -> tuple[Any, ...]:
        return self._times_waves(at, smooth_sign(at.velocity, self.reversal))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        slope = smooth_sign_by_reversal(motion.velocity, self.reversal)
        return {"reversal": self.on_joints(robot, *self._times_waves(motion, slope))}

    def _times_waves(self, at: Any, profile: Any) -> tuple[Any, ...]:
        """A profile multiplied by each of the waves along the joint."""
        return tuple(profile * wave for wave in _waves(self.harmonic * at.position, self.count))
