"""Trajectory: position, velocity, acceleration and jerk at any time."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.motion import Motion

from .errors import OutsideTrajectory

ROUNDING = 1e-9
"""Time before the start or after the end that counts as rounding [s]."""
PART_OF_TICK = 1e-6
"""Share of a sampling period by which a duration may miss a whole number of periods."""


UNITS = {"position": "rad", "velocity": "rad/s", "acceleration": "rad/s^2", "jerk": "rad/s^3"}
"""Units of a revolute joint."""


def unit_of(name: str, position: str = "rad") -> str:
    """Unit of a quantity of `UNITS`, or of "torque", for a joint whose position is in "rad" or "m"."""
    if name == "torque":
        return "N m" if position == "rad" else "N"
    return UNITS[name].replace("rad", position)


class State(NamedTuple):
    """Position, velocity and acceleration of the joints at one instant, shape (n,), units as in `States`."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray

    @classmethod
    def at_rest(cls, position: np.ndarray) -> "State":
        """A state at rest at a position, shape (n,) [rad]."""
        return cls(np.asarray(position, float), np.zeros(len(position)), np.zeros(len(position)))


class States(NamedTuple):
    """States over time."""

    time: np.ndarray  # shape (t,) [s]
    position: np.ndarray  # shape (t, n) [rad], or [m] for a prismatic joint
    velocity: np.ndarray  # shape (t, n) [rad/s]
    acceleration: np.ndarray  # shape (t, n) [rad/s^2]
    jerk: np.ndarray  # shape (t, n) [rad/s^3]

    def motion(self, payload: str = "") -> Motion:
        """Motion with these states, as effects take it."""
        return Motion.of(self.time, self.position, self.velocity, self.acceleration, payload=payload)

    def state(self, row: int) -> State:
        """State in one row."""
        return State(self.position[row], self.velocity[row], self.acceleration[row])


class Range(NamedTuple):
    """Smallest and largest value that a quantity reaches, and when; each field has shape (n,)."""

    lower: np.ndarray
    upper: np.ndarray
    lower_time: np.ndarray
    upper_time: np.ndarray

    @property
    def largest(self) -> np.ndarray:
        """Largest absolute value."""
        return np.maximum(np.abs(self.lower), np.abs(self.upper))


def widest(ranges: Sequence[Range], begins: np.ndarray | float = 0.0) -> Range:
    """Smallest and largest value over ranges that begin at times of shape (k,) [s]."""
    lower, upper, lower_time, upper_time = np.moveaxis(np.array(ranges), 1, 0)
    offset = np.reshape(begins, (-1, 1))
    return lowest_and_highest(lower, upper, lower_time + offset, upper_time + offset)


def lowest_and_highest(
    lower: np.ndarray, upper: np.ndarray, lower_time: np.ndarray, upper_time: np.ndarray
) -> Range:
    """Smallest lower and largest upper value of each joint, and when; arguments have shape (k, n)."""
    low, high, joint = np.argmin(lower, axis=0), np.argmax(upper, axis=0), np.arange(lower.shape[1])
    return Range(lower[low, joint], upper[high, joint], lower_time[low, joint], upper_time[high, joint])


class Extremes(NamedTuple):
    """Ranges that a trajectory reaches, between samples too."""

    position: Range
    velocity: Range
    acceleration: Range
    jerk: Range


class Trajectory(ABC):
    """A motion of all joints from time zero to its duration."""

    @property
    @abstractmethod
    def duration(self) -> float:
        """Time from start to end [s]."""

    @property
    @abstractmethod
    def dof(self) -> int:
        """Number of joints n."""

    @abstractmethod
    def at(self, time: np.ndarray) -> States:
        """States at times of shape (t,) [s].

        Raises:
            OutsideTrajectory: A time is before zero or after the duration.
        """

    @abstractmethod
    def extremes(self) -> Extremes:
        """Largest and smallest position, velocity, acceleration and jerk, exact or as proven bounds."""

    def state_at(self, time: float) -> State:
        """State at one time [s]."""
        return self.at(np.array([time])).state(0)

    def every(self, tick: float) -> States:
        """States at every sampling period `tick` [s] from the start; the last is at or before the end."""
        return self.at(np.arange(int(np.floor(self.duration / tick + PART_OF_TICK)) + 1) * tick)

    def inside(self, time: np.ndarray) -> np.ndarray:
        """Times clipped to the trajectory where they exceed it by rounding.

        Raises:
            OutsideTrajectory: A time is before zero or after the duration.
        """
        time = np.atleast_1d(np.asarray(time, float))
        outside = (time < -ROUNDING) | (time > self.duration + ROUNDING) | ~np.isfinite(time)
        if np.any(outside):
            raise OutsideTrajectory(
                f"time {time[outside][0]:g} s is outside the trajectory, which lasts from 0 to "
                f"{self.duration:g} s"
            )
        return np.clip(time, 0.0, self.duration)


def whole_ticks(duration: float, tick: float) -> float:
    """The duration rounded up to a whole number of sampling periods [s]."""
    return float(np.ceil(duration / tick - PART_OF_TICK) * tick)
