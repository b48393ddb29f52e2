"""An elastic gear, on which the link lags behind the motor and oscillates."""

from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from ..arm.tangent import Tangent
from .gear import Gear, Spring
from .measurement import require
from .twist import Twist, bent


@dataclass(frozen=True)
class JointElasticity(Gear):
    """A spring and a damper between motor and link, reflected to the joint.

    Attributes:
        stiffness: Stiffness [N m/rad].
        damping: Damping [N m s/rad].
    """

    stiffness: float
    damping: float = 0.0

    def twist(self, tangent: Tangent, load: np.ndarray, joint: int, step: float) -> Twist:
        weight, drag, inertia = tangent.own(joint)
        return bent(inertia, self.damping + drag, self.stiffness + weight, load, step)

    def spring(self, inertia: float) -> Spring:
        return Spring(self.stiffness, self.damping)

    def check(self, robot: Robot) -> None:
        super().check(robot)
        require("joint_elasticity", "stiffness", self.stiffness)
        require("joint_elasticity", "damping", self.damping, above=False)
