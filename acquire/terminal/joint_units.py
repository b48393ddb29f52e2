"""Positions as a person reads them: degrees of a revolute joint, millimetres of a prismatic one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exidyn.drivers import Arm
from exidyn.identification.arm.robot import Robot
from exidyn.identification.text_table import fixed


@dataclass(frozen=True)
class JointUnits:
    """Names, units and limits of the joints for what is printed.

    Attributes:
        joints: Names.
        units: Unit of each position.
        scale: Shown per [rad] or [m], shape (n,).
        lower: Position limits, shape (n,) [rad] or [m]; minus infinity for none.
        upper: Position limits, shape (n,) [rad] or [m]; infinity for none.
    """

    joints: tuple[str, ...]
    units: tuple[str, ...]
    scale: np.ndarray
    lower: np.ndarray
    upper: np.ndarray

    @classmethod
    def of(cls, robot: Robot) -> "JointUnits":
        """Of a robot that is known."""
        units = tuple("deg" if revolute else "mm" for revolute in robot.revolute)
        scale = np.where(robot.revolute, np.degrees(1.0), 1e3)
        return cls(robot.joints, units, scale, robot.limits.position_lower, robot.limits.position_upper)

    @classmethod
    def unknown(cls, arm: Arm) -> "JointUnits":
        """Of an arm of which only the number of joints is known: as the driver gives it."""
        return cls(arm.joints, ("rad",) * arm.dof, np.ones(arm.dof), arm.position_lower, arm.position_upper)

    def beyond(self, position: np.ndarray) -> np.ndarray:
        """Which joints are beyond their limits, shape (n,); none of those of which nothing is known."""
        outside: np.ndarray = (position < self.lower) | (position > self.upper)
        return outside

    def text(self, position: np.ndarray, joint: int) -> str:
        """The position of a joint, with its unit."""
        return f"{fixed(self.scale[joint] * position[joint], 2)} {self.units[joint]}"

    def range_text(self, joint: int) -> str:
        """The limits of a joint, without unit; empty where there are none."""
        ends = [self.scale[joint] * end[joint] for end in (self.lower, self.upper)]
        return f"{fixed(ends[0], 1)} to {fixed(ends[1], 1)}" if np.isfinite(ends).any() else ""


def one_unit(units: Sequence[str]) -> str:
    """The unit of all, or those of each with slashes between."""
    return units[0] if len(set(units)) == 1 else "/".join(units)
