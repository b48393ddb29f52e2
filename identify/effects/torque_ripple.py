"""Torque that oscillates along a turn of the motor: cogging and commutation errors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import Effect, JointEffect, MotionGradient, Parameter
from .joint_state import JointState, Scalar


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
        numbers = [k * self.harmonic for k in range(1, self.count + 1)]
        return self.on_each(robot, *((f"R{wave}{k:g}_", "N m") for k in numbers for wave in ("cos", "sin")))

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        joints, angle = (
            self.columns(robot),
            self.harmonic * robot.gear_ratio * (motion.position @ robot.coupling.T),
        )
        waves = [np.zeros_like(angle) for _ in range(2 * self.count)]
        for k in range(1, self.count + 1):
            turned = k * angle[:, joints]
            waves[2 * k - 2][:, joints], waves[2 * k - 1][:, joints] = np.cos(turned), np.sin(turned)
        on_motors = self.on_joints(robot, *waves)
        if np.array_equal(robot.coupling, np.eye(robot.dof)):
            return on_motors
        return np.einsum("mj,tmp->tjp", robot.coupling, on_motors)

    def joint_torque(self, robot: Robot, values: np.ndarray, state: JointState) -> Sequence[Scalar]:
        def waves(motor: int) -> Sequence[Scalar]:
            turned = sum(float(c) * q for c, q in zip(robot.coupling[motor], state.position, strict=True))
            angle = self.harmonic * float(robot.gear_ratio[motor]) * turned
            return [wave(k * angle) for k in range(1, self.count + 1) for wave in (np.cos, np.sin)]

        on_motors = self.on_scalars(robot, values, waves)
        return [
            sum(float(c) * f for c, f in zip(column, on_motors, strict=True)) for column in robot.coupling.T
        ]

    def motion_gradient(
        self, robot: Robot, motion: Motion, weights: np.ndarray, known: np.ndarray
    ) -> MotionGradient:
        # with coupling, the angle of a motor depends on several joints
        return Effect.motion_gradient(self, robot, motion, weights, known)
