"""Limits that a live view draws: those that somebody stated."""

from typing import NamedTuple

import numpy as np

from exidyn.identify.arm.robot import Robot


class DrawnLimits(NamedTuple):
    """Limits of one quantity that are finite, the lower ones before the upper.

    Attributes:
        joints: Which joint each belongs to, shape (k,).
        values: Shape (k,) in the unit of the quantity.
    """

    joints: np.ndarray
    values: np.ndarray

    @classmethod
    def of(cls, lower: np.ndarray, upper: np.ndarray) -> "DrawnLimits":
        """Those that are finite of two per joint, each (n,)."""
        both = np.concatenate([lower, upper])
        finite = np.flatnonzero(np.isfinite(both))
        return cls(finite % len(lower), both[finite])


def finite_limits(robot: Robot, effort: str) -> dict[str, DrawnLimits]:
    """Limits that are drawn, by quantity; without those of which nobody said anything.

    Args:
        robot: The arm.
        effort: "torque", or "current" for those that make the largest torque.
    """
    limits = robot.limits
    largest = limits.torque / np.abs(robot.drive_gain) if effort == "current" else limits.torque
    found = {
        "position": DrawnLimits.of(limits.position_lower, limits.position_upper),
        "velocity": DrawnLimits.of(limits.velocity_lower, limits.velocity),
        effort: DrawnLimits.of(-largest, largest),
    }
    return {quantity: some for quantity, some in found.items() if len(some.joints)}
