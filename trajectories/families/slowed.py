"""Slowed: the same path at a share of the speed."""

from dataclasses import dataclass

import numpy as np

from ..errors import BadLimits
from ..trajectory import Extremes, Range, States, Trajectory


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
