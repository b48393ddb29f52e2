"""Dry friction: constant torque against the motion."""

from dataclasses import dataclass

import numpy as np

from ..motion import Motion
from ..robot import Robot
from .effect import JointEffect, Parameter, shape


@dataclass(frozen=True)
class CoulombFriction(JointEffect):
    r"""Torque :math:`F_c \tanh(\dot q / v_r)`, the paper's :math:`Fc_j`.

    Attributes:
        reversal: Velocity :math:`v_r` over which the sign turns [rad/s].
    """

    reversal: float = shape(0.003, "rad/s", 1e-4, 0.1)

    def parameters(self, robot: Robot) -> list[Parameter]:
        return [Parameter(f"Fc{joint + 1}", "N m", 0.0) for joint in self.columns(robot)]

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, np.tanh(motion.velocity / self.reversal))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        ratio = motion.velocity / self.reversal
        slope = -ratio / self.reversal / np.cosh(np.clip(ratio, -300, 300)) ** 2
        return {"reversal": self.on_joints(robot, slope)}
