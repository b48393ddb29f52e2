"""Dry friction that differs between the two directions."""

from dataclasses import dataclass

import numpy as np

from ..motion import Motion
from ..robot import Robot
from .effect import JointEffect, Parameter, shape
from .smooth_sign import smooth_sign, smooth_sign_by_reversal


@dataclass(frozen=True)
class FrictionAsymmetry(JointEffect):
    r"""Torque :math:`F_a |\tanh(\dot q / v_r)|`, the even part of dry friction.

    With `CoulombFriction`, the joint brakes with :math:`F_c + F_a` forward and :math:`F_c - F_a`
    backward. Unlike a `CurrentOffset` it is gone at standstill; a motion that never stands hardly
    tells the two apart.

    Attributes:
        reversal: Velocity :math:`v_r` over which the friction builds up [rad/s].
    """

    reversal: float = shape(0.003, "rad/s", 1e-4, 0.1)

    def parameters(self, robot: Robot) -> list[Parameter]:
        return [Parameter(f"Fa{joint + 1}", "N m") for joint in self.columns(robot)]

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, np.abs(smooth_sign(motion.velocity, self.reversal)))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        slope = smooth_sign_by_reversal(motion.velocity, self.reversal)
        return {"reversal": self.on_joints(robot, np.sign(motion.velocity) * slope)}
