"""How much of the robot's limits a plan uses, exactly and joint by joint."""

from typing import NamedTuple

import numpy as np

from ..limits.check import ROUNDING
from ..limits.usable_limits import ranges
from ..trajectory import Range
from .plan import Plan


class Use(NamedTuple):
    """One quantity of all joints against its limits; the limits infinite where not given.

    Attributes:
        name: "position", "velocity", "acceleration", "jerk" or "torque".
        reached: Smallest and largest value and when, each shape (n,).
        lower: Shape (n,).
        upper: Shape (n,).
    """

    name: str
    reached: Range
    lower: np.ndarray
    upper: np.ndarray

    def shares(self, values: np.ndarray) -> np.ndarray:
        """Way from the middle to the limits, from -1 to 1, NaN where one is unknown; shape (..., n) [-].

        The middle is between the position limits; of everything else it is zero.
        """
        known = np.isfinite(self.lower) & np.isfinite(self.upper)
        lower, upper = np.where(known, self.lower, -1.0), np.where(known, self.upper, 1.0)
        middle = 0.5 * (lower + upper) if self.name == "position" else np.zeros(len(known))
        away = values - middle
        return np.where(known, np.where(away > 0, away / (upper - middle), -away / (lower - middle)), np.nan)

    @property
    def share(self) -> np.ndarray:
        """Largest share that is used, 1 at the limit, NaN where it is unknown; shape (n,) [-]."""
        return np.maximum(self.shares(self.reached.upper), -self.shares(self.reached.lower))

    @property
    def violated(self) -> np.ndarray:
        """Which joints go beyond a limit, shape (n,), bool."""
        return self.beyond(self.reached.upper) | self.beyond(self.reached.lower)

    def beyond(self, values: np.ndarray, joint: int | slice = slice(None)) -> np.ndarray:
        """Which values, (..., n) or of one joint, are beyond the limits by more than rounding."""
        lower, upper = self.lower[joint], self.upper[joint]
        slack = ROUNDING * np.where(np.isfinite(upper - lower), upper - lower, 1.0)
        return (values > upper + slack) | (values < lower - slack)


def limit_use(plan: Plan) -> list[Use]:
    """Position, velocity, acceleration and jerk against the limits, between samples too."""
    bounds, extremes = ranges(plan.limits), plan.trajectory.extremes()
    return [Use(name, reached, *bounds[name]) for name, reached in extremes._asdict().items()]


def percent(share: float, unknown: str) -> str:
    """The share of a limit that is used in per cent, or what stands for one that is not known."""
    return f"{100.0 * abs(share):.1f}" if np.isfinite(share) else unknown
