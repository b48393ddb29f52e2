"""Motions made of motions: one after another, or at a share of the speed."""

from dataclasses import dataclass

import numpy as np

from ..errors import BadLimits, NotContinuous
from ..trajectory import UNITS, Extremes, Range, State, States, Trajectory, widest

JOIN = 1e-6
"""Step in position [rad], velocity [rad/s] or acceleration [rad/s^2] between two parts that is rounding: a
hundredth of what a 16 bit encoder sees, a hundred times what Ruckig misses its target by."""


@dataclass(frozen=True, eq=False)
class Sequence(Trajectory):
    """Motions one after another, each of which begins as the one before it ends.

    Attributes:
        parts: At least one.
    """

    parts: tuple[Trajectory, ...]

    def __post_init__(self) -> None:
        if not self.parts or len({part.dof for part in self.parts}) != 1:
            raise NotContinuous(
                f"a sequence of parts with {[part.dof for part in self.parts]} joints; "
                "expected one part or more, all of the same arm"
            )
        for number, (before, after) in enumerate(zip(self.parts, self.parts[1:], strict=False), start=1):
            _require_join(number, before.state_at(before.duration), after.state_at(0.0))

    @property
    def duration(self) -> float:
        return float(self.begins[-1])

    @property
    def dof(self) -> int:
        return self.parts[0].dof

    @property
    def begins(self) -> np.ndarray:
        """When each part begins, and when the last ends, shape (parts + 1,) [s]."""
        return np.concatenate([[0.0], np.cumsum([part.duration for part in self.parts])])

    def at(self, time: np.ndarray) -> States:
        """States at given times; at a join, those of the part which begins there."""
        time = self.inside(time)
        begins = self.begins
        owner = np.clip(np.searchsorted(begins, time, side="right") - 1, 0, len(self.parts) - 1)
        columns = np.empty((4, len(time), self.dof))
        for index in np.unique(owner):
            mine = owner == index
            columns[:, mine] = self.parts[index].at(time[mine] - begins[index])[1:]
        return States(time, *columns)

    def extremes(self) -> Extremes:
        found = [part.extremes() for part in self.parts]
        return Extremes(*(widest(ranges, self.begins[:-1]) for ranges in zip(*found, strict=True)))


def _require_join(number: int, before: State, after: State) -> None:
    for name, left, right in zip(State._fields, before, after, strict=True):
        for joint in np.flatnonzero(~(np.abs(right - left) <= JOIN)):
            raise NotContinuous(
                f"joint {joint + 1}: {name} jumps from {left[joint]:.9g} to {right[joint]:.9g} {UNITS[name]} "
                f"between parts {number} and {number + 1}; a part must begin as the one before it ends. "
                "Try a move between"
            )


@dataclass(frozen=True, eq=False)
class Slowed(Trajectory):
    """A motion through the same positions in more time.

    Attributes:
        full: The motion at full speed.
        speed: Share of its speed, above 0 and up to 1 [-].
    """

    full: Trajectory
    speed: float

    def __post_init__(self) -> None:
        if not 0.0 < self.speed <= 1.0:
            raise BadLimits(f"a speed of {self.speed:g}; it must be above 0 and at most 1, such as 0.1")

    @property
    def duration(self) -> float:
        return self.full.duration / self.speed

    @property
    def dof(self) -> int:
        return self.full.dof

    def at(self, time: np.ndarray) -> States:
        time = self.inside(time)
        states = self.full.at(np.minimum(time * self.speed, self.full.duration))
        powers = (states[1 + order] * self.speed**order for order in range(4))
        return States(time, *powers)

    def extremes(self) -> Extremes:
        slower = []
        for order, (lower, upper, *times) in enumerate(self.full.extremes()):
            share = self.speed**order
            slower.append(Range(lower * share, upper * share, *(time / self.speed for time in times)))
        return Extremes(*slower)
