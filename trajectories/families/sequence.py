"""Motions made of other motions: one after another, or slowed down."""

from dataclasses import dataclass

import numpy as np

from ..errors import BadLimits, NotContinuous
from ..trajectory import UNITS, Extremes, Range, State, States, Trajectory, widest

JOIN = 1e-6
"""Step in position [rad], velocity [rad/s] or acceleration [rad/s^2] between two parts that is rounding:
a hundredth of the resolution of a 16 bit encoder, a hundred times the error of Ruckig at its target."""


@dataclass(frozen=True, eq=False)
class Sequence(Trajectory):
    """Motions one after another, each of which begins as the one before it ends."""

    parts: tuple[Trajectory, ...]  # motions in order, at least one

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
        """Times at which each part begins and the last ends, shape (parts + 1,) [s]."""
        return np.concatenate([[0.0], np.cumsum([part.duration for part in self.parts])])

    def at(self, time: np.ndarray) -> States:
        """States at times of shape (t,) [s]; at a join, those of the part that begins there."""
        time = self.inside(time)
        begins = self.begins
        part = np.clip(np.searchsorted(begins, time, side="right") - 1, 0, len(self.parts) - 1)
        columns = np.empty((4, len(time), self.dof))
        for index in np.unique(part):
            inside = part == index
            columns[:, inside] = self.parts[index].at(time[inside] - begins[index])[1:]
        return States(time, *columns)

    def extremes(self) -> Extremes:
        extremes = [part.extremes() for part in self.parts]
        return Extremes(*(widest(ranges, self.begins[:-1]) for ranges in zip(*extremes, strict=True)))


def _require_join(number: int, before: State, after: State) -> None:
    for name, end, start in zip(State._fields, before, after, strict=True):
        for joint in np.flatnonzero(~(np.abs(start - end) <= JOIN)):
            raise NotContinuous(
                f"joint {joint + 1}: {name} jumps from {end[joint]:.9g} to {start[joint]:.9g} {UNITS[name]} "
                f"between parts {number} and {number + 1}; a part must begin as the previous part ends. "
                "Try to insert a move between them"
            )


@dataclass(frozen=True, eq=False)
class Slowed(Trajectory):
    """A motion through the same positions in more time."""

    full: Trajectory  # motion at full speed
    speed: float  # share of the full speed, above 0 and up to 1 [-]

    def __post_init__(self) -> None:
        if not 0.0 < self.speed <= 1.0:
            raise BadLimits(f"the speed is {self.speed:g}; it must be above 0 and at most 1, such as 0.1")

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
