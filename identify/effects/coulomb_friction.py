"""Dry friction: constant torque against the motion."""

from dataclasses import dataclass

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import JointEffect, Parameter, shape
from .smooth_sign import smooth_sign, smooth_sign_by_reversal


@dataclass(frozen=True)
class CoulombFriction(JointEffect):
    r"""Torque :math:`F_c \tanh(\dot q / v_r)`, the paper's :math:`Fc_j`.

    Attributes:
        reversal: Velocity :math:`v_r` over which the sign changes [rad/s].
    """

    reversal: float = shape(0.003, "rad/s", 1e-4, 0.1)

    def parameters(self, robot: Robot) -> list[Parameter]:
        return [Parameter(f"Fc{joint + 1}", robot.unit(joint, "N m"), 0.0) for joint in self.columns(robot)]

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, smooth_sign(motion.velocity, self.reversal))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        slope = smooth_sign_by_reversal(motion.velocity, self.reversal)
        return {"reversal": self.on_joints(robot, slope)}
