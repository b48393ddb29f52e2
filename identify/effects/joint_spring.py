"""A spring across a joint: cables, hoses, or a torsion spring."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..motion import Motion
from ..robot import Robot
from .effect import JointEffect, Parameter


@dataclass(frozen=True)
class JointSpring(JointEffect):
    r"""Torque :math:`k (q - q_0)`, written linearly as :math:`K_s q + T_s` with :math:`T_s = -k q_0`.

    Beside a `CurrentOffset` on the same joint, :math:`T_s` and the offset are one and the same column.
    """

    transmitted: ClassVar[bool] = True
    smooth: ClassVar[bool] = True

    def parameters(self, robot: Robot) -> list[Parameter]:
        return [
            parameter
            for joint in self.columns(robot)
            for parameter in (
                Parameter(f"Ks{joint + 1}", "N m/rad", 0.0),
                Parameter(f"Ts{joint + 1}", "N m"),
            )
        ]

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, motion.position, np.ones_like(motion.position))
