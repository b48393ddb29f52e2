"""Efforts of all or some drives that are recorded later or earlier than positions."""

from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from ..errors import RobotError
from .measurement import Measurement, on_joints

LONGEST = 1.0
"""Longest delay [s]: no controller acts on older currents."""


@dataclass(frozen=True)
class TimeDelay(Measurement):
    """A delay of currents or torques; several delays of one joint add up.

    Attributes:
        seconds: Delay of recorded efforts relative to positions; negative if they are earlier [s].
        joints: Names of the joints with delayed efforts; None for all.
    """

    seconds: float
    joints: tuple[str, ...] | None = None

    def delay(self, robot: Robot) -> np.ndarray:
        return on_joints(robot, self.joints, self.seconds, 0.0)

    def check(self, robot: Robot) -> None:
        super().check(robot)
        if not abs(self.seconds) <= LONGEST:
            raise RobotError(
                f"time_delay seconds: {self.seconds:g} s exceeds {LONGEST:g} s; give the delay in seconds"
            )
