"""`Gear`: a joint whose link can move relative to its motor."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..arm.tangent import Tangent
from .measurement import Measurement
from .twist import Twist


class Spring(NamedTuple):
    """Gear in a simulated arm: stiffness [N m/rad], damping [N m s/rad], width of the play [rad]."""

    stiffness: float
    damping: float
    backlash: float = 0.0


@dataclass(frozen=True)
class Gear(Measurement, ABC):
    """A gear that twists under load, while the position is measured at the motor.

    Attributes:
        joint: Name of the joint.
    """

    joint: str

    @abstractmethod
    def twist(self, tangent: Tangent, load: np.ndarray, joint: int, step: float) -> Twist:
        """Angle by which the motor leads its link.

        Args:
            tangent: Derivatives of the links' torque along the motion.
            load: Torque that a rigid gear would transmit, shape (t,) [N m].
            joint: Index of the joint.
            step: Sampling period [s].
        """

    @abstractmethod
    def spring(self, inertia: float) -> Spring:
        """Gear in a simulated arm, for a mean inertia of the link [kg m^2]."""

    def check(self, robot: Robot) -> None:
        super().check(robot)
        robot.index(self.joint)
