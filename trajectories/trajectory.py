"""Trajectory: position, velocity, acceleration and jerk at any time."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.motion import Motion

from .errors import OutsideTrajectory

ROUNDING = 1e-9
"""Seconds before the start or after the end that are taken as rounding of the tick's time."""
PART_OF_TICK = 1e-6
"""Share of a tick by which a duration may miss a whole number of ticks."""


UNITS = {"position": "rad", "velocity": "rad/s", "acceleration": "rad/s^2", "jerk": "rad/s^3"}
"""Of a revolute joint."""


def unit_of(name: str, position: str = "rad") -> str:
    """Unit of a quantity, or of the torque, of a joint whose position is in `position`, "rad" or "m"."""
    if name == "torque":
        return "N m" if position == "rad" else "N"
    return UNITS[name].replace("rad", position)


class State(NamedTuple):
    """Where the joints are and how they move, at one instant; units as in `States`, each of shape (n,)."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray

    @classmethod
    def at_rest(cls, position: np.ndarray) -> "State":
        """Standing still."""
        return cls(np.asarray(position, float), np.zeros(len(position)), np.zeros(len(position)))


class States(NamedTuple):
    """States over time.

    Attributes:
        time: Shape (t,) [s].
        position: Shape (t, n) [rad], or [m] where the joint slides.
        velocity: Shape (t, n) [rad/s].
        acceleration: Shape (t, n) [rad/s^2].
        jerk: Shape (t, n) [rad/s^3].
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray

    def motion(self, payload: str = "") -> Motion:
        """The same as the input of effects."""
        return Motion.of(self.time, self.position, self.velocity, self.acceleration, payload=payload)

    def state(self, row: int) -> State:
        """One instant."""
        return State(self.position[row], self.velocity[row], self.acceleration[row])


class Range(NamedTuple):
    """Smallest and largest value that a quantity reaches, and when; each of shape (n,)."""

    lower: np.ndarray
    upper: np.ndarray
    lower_time: np.ndarray
    upper_time: np.ndarray


def widest(ranges: Sequence[Range], begins: np.ndarray | float = 0.0) -> Range:
    """Smallest and largest of all; times are later by when each range `begins`, shape (k,) [s]."""
    lower, upper, lower_time, upper_time = np.moveaxis(np.array(ranges), 1, 0)
    later = np.reshape(begins, (-1, 1))
    return lowest_and_highest(lower, upper, lower_time + later, upper_time + later)


def lowest_and_highest(
    lower: np.ndarray, upper: np.ndarray, lower_time: np.ndarray, upper_time: np.ndarray
) -> Range:
    """The lowest of lower and the highest of upper values of each joint, and when; each of shape (k, n)."""
    low, high, joint = np.argmin(lower, axis=0), np.argmax(upper, axis=0), np.arange(lower.shape[1])
    return Range(lower[low, joint], upper[high, joint], lower_time[low, joint], upper_time[high, joint])


class Extremes(NamedTuple):
    """What a trajectory reaches anywhere, between samples too."""

    position: Range
    velocity: Range
    acceleration: Range
    jerk: Range


@dataclass(frozen=True, eq=False)
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
        """States at given times, shape (t,) [s].

        Raises:
            OutsideTrajectory: A time before zero or after the duration.
        """

    @abstractmethod
    def extremes(self) -> Extremes:
        """The largest and smallest position, velocity, acceleration and jerk, exactly or as proved bounds."""

    def state_at(self, time: float) -> State:
        """State at one time [s]."""
        return self.at(np.array([time])).state(0)

    def every(self, tick: float) -> States:
        """States at every tick from start to end; the last tick is at or before the end."""
        return self.at(np.arange(int(np.floor(self.duration / tick + PART_OF_TICK)) + 1) * tick)

    def inside(self, time: np.ndarray) -> np.ndarray:
        """The times, rounding at both ends taken off.

        Raises:
            OutsideTrajectory: A time before zero or after the duration.
        """
        time = np.atleast_1d(np.asarray(time, float))
        outside = (time < -ROUNDING) | (time > self.duration + ROUNDING) | ~np.isfinite(time)
        if np.any(outside):
            raise OutsideTrajectory(
                f"the trajectory lasts from 0 to {self.duration:g} s; asked for {time[outside][0]:g} s"
            )
        return np.clip(time, 0.0, self.duration)


def whole_ticks(duration: float, tick: float) -> float:
    """The next whole number of ticks, as a time [s]."""
    return float(np.ceil(duration / tick - PART_OF_TICK) * tick)
