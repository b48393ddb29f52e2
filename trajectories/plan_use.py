"""How much of the robot's limits a plan uses, exactly and joint by joint."""

from typing import NamedTuple

import numpy as np
from exidyn.identify.model import Model

from .plan import Plan
from .trajectory import Range

DERIVATIVES = ("position", "velocity", "acceleration", "jerk")

ROUNDING = 1e-9
"""Share of a limit by which arithmetic may overshoot it: a plan that touches its limit keeps it."""


class Use(NamedTuple):
    """One quantity of all joints against its limits; the limits infinite where nobody said.

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

    @property
    def share(self) -> np.ndarray:
        """Largest part of the way from the middle to a limit, 1 at the limit, NaN without; shape (n,) [-]."""
        known = np.isfinite(self.lower) & np.isfinite(self.upper)
        lower, upper = np.where(known, self.lower, -1.0), np.where(known, self.upper, 1.0)
        middle = 0.5 * (lower + upper) if self.name == "position" else np.zeros(len(known))
        up = (self.reached.upper - middle) / (upper - middle)
        down = (self.reached.lower - middle) / (lower - middle)
        return np.where(known, np.maximum(up, down), np.nan)

    @property
    def violated(self) -> np.ndarray:
        """Which joints go beyond a limit, shape (n,), bool."""
        return self.beyond(self.reached.upper) | self.beyond(self.reached.lower)

    def beyond(self, values: np.ndarray) -> np.ndarray:
        """Which values (..., n) are beyond a limit."""
        size = np.where(np.isfinite(self.upper - self.lower), self.upper - self.lower, 1.0)
        return (values > self.upper + ROUNDING * size) | (values < self.lower - ROUNDING * size)


def limit_use(plan: Plan) -> list[Use]:
    """Position, velocity, acceleration and jerk against the limits, between samples too."""
    limits, extremes = plan.limits, plan.trajectory.extremes()
    bounds = {
        "position": (limits.position_lower, limits.position_upper),
        "velocity": (limits.velocity_lower, limits.velocity),
        "acceleration": (limits.acceleration_lower, limits.acceleration),
        "jerk": (-limits.jerk, limits.jerk),
    }
    return [Use(name, getattr(extremes, name), *bounds[name]) for name in DERIVATIVES]


class Torque(NamedTuple):
    """Torque that the model believes the motion to take.

    Attributes:
        time: Every tick, shape (t,) [s].
        values: Shape (t, n) [N m].
        use: Against the limits, at the ticks.
    """

    time: np.ndarray
    values: np.ndarray
    use: Use


def believed_torque(plan: Plan, model: Model) -> Torque:
    """Torque of the motion by the model's beliefs, without a payload."""
    states = plan.trajectory.every(plan.tick)
    motion = model.loaded(states.motion())
    values = model.torque(motion, model.believed_values)
    low, high = np.argmin(values, axis=0), np.argmax(values, axis=0)
    joints = np.arange(values.shape[1])
    reached = Range(values[low, joints], values[high, joints], states.time[low], states.time[high])
    return Torque(states.time, values, Use("torque", reached, -plan.limits.torque, plan.limits.torque))


def unit_of(name: str, position: str) -> str:
    """Unit of a quantity of a joint whose position is in `position`, "rad" or "m"."""
    powers = {"position": "", "velocity": "/s", "acceleration": "/s^2", "jerk": "/s^3"}
    if name == "torque":
        return "N m" if position == "rad" else "N"
    return position + powers[name]
