"""Dry friction in proportion to the torque that the gear transmits."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import JointEffect, Parameter, shape
from .smooth_sign import smooth_sign, smooth_sign_by_reversal


@dataclass(frozen=True)
class LoadDependentFriction(JointEffect):
    r"""Torque :math:`\mu |\tau_{load}| \tanh(\dot q / v_r)`: teeth and bearings pressed by the load.

    The load is `Motion.load`, the nominal torque through the gear; the measured torque would carry
    its noise, and the friction itself, into the column.

    Attributes:
        reversal: Velocity :math:`v_r` over which the sign changes [rad/s].
    """

    reversal: float = shape(0.003, "rad/s", 1e-4, 0.1)

    needs_load: ClassVar[bool] = True

    def parameters(self, robot: Robot) -> list[Parameter]:
        return [Parameter(f"mu{joint + 1}", "1", 0.0) for joint in self.columns(robot)]

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, smooth_sign(motion.velocity, self.reversal) * np.abs(motion.load))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        slope = smooth_sign_by_reversal(motion.velocity, self.reversal) * np.abs(motion.load)
        return {"reversal": self.on_joints(robot, slope)}
