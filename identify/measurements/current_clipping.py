"""Recorded currents that are clipped while the torque still increases."""

from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from .measurement import Measurement, on_joints, require


@dataclass(frozen=True)
class CurrentClipping(Measurement):
    """A sensor with a limited range; a fit leaves out clipped samples.

    Attributes:
        limit: Largest recorded effort in both directions [A; N m if torque is recorded].
        joints: Names of the joints whose sensors are clipped; None for all.
    """

    limit: float
    joints: tuple[str, ...] | None = None

    def current_limit(self, robot: Robot) -> np.ndarray:
        return on_joints(robot, self.joints, self.limit, np.inf)

    def check(self, robot: Robot) -> None:
        super().check(robot)
        require("current_clipping", "limit", self.limit)
