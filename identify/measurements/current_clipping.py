"""Recorded currents that are clipped while the torque goes on rising."""

from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from .measurement import Measurement, on_joints, require


@dataclass(frozen=True)
class CurrentClipping(Measurement):
    """A sensor that shows no more than its largest current; a fit leaves such samples out.

    Attributes:
        limit: Largest effort that is recorded, either way [A; N m where torque is recorded].
        joints: Names of the joints whose sensors are clipped; None for all.
    """

    limit: float
    joints: tuple[str, ...] | None = None

    def current_limit(self, robot: Robot) -> np.ndarray:
        return on_joints(robot, self.joints, self.limit, np.inf)

    def check(self, robot: Robot) -> None:
        super().check(robot)
        require("current_clipping", "limit", self.limit)
