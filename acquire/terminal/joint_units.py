"""Joint positions in the units that a person reads: degrees (revolute) or millimeters (prismatic)."""

from dataclasses import dataclass

import numpy as np

from exidyn.drivers import Arm
from exidyn.identification.arm.robot import Robot
from exidyn.identification.text_table import fixed


@dataclass(frozen=True)
class JointUnits:
    """Names, units and limits with which joint positions are printed."""

    joints: tuple[str, ...]  # joint names
    units: tuple[str, ...]  # printed unit of each joint's position
    scale: np.ndarray  # printed value per rad or m, shape (n,)
    lower: np.ndarray  # lower position limits, shape (n,) [rad] or [m]; minus infinity for none
    upper: np.ndarray  # upper position limits, shape (n,) [rad] or [m]; infinity for none

    @classmethod
    def of(cls, robot: Robot) -> "JointUnits":
        """Units and limits of a known robot."""
        units = tuple("deg" if revolute else "mm" for revolute in robot.revolute)
        scale = np.where(robot.revolute, np.degrees(1.0), 1e3)
        return cls(robot.joints, units, scale, robot.limits.position_lower, robot.limits.position_upper)

    @classmethod
    def unknown(cls, arm: Arm) -> "JointUnits":
        """Radians and the driver's limits, for an arm of which only the number of joints is known."""
        return cls(arm.joints, ("rad",) * arm.dof, np.ones(arm.dof), arm.position_lower, arm.position_upper)

    def beyond(self, position: np.ndarray) -> np.ndarray:
        """Which joints are beyond their limits, shape (n,); joints without a position count as within."""
        outside: np.ndarray = (position < self.lower) | (position > self.upper)
        return outside

    def text(self, position: np.ndarray, joint: int) -> str:
        """Position of a joint with its unit."""
        return f"{fixed(self.scale[joint] * position[joint], 2)} {self.units[joint]}"

    def range_text(self, joint: int) -> str:
        """Position limits of a joint without unit; empty if it has none."""
        ends = [self.scale[joint] * end[joint] for end in (self.lower, self.upper)]
        return f"{fixed(ends[0], 1)} to {fixed(ends[1], 1)}" if np.isfinite(ends).any() else ""
