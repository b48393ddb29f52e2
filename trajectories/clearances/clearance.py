"""Clearance: how much room is left before something collides or leaves its region."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..trajectory import States, Trajectory

RESOLUTION = 0.5e-3
"""How much nearer than what it found a check may miss [m]: far below what a collision mesh is true to."""


class Approach(NamedTuple):
    """The nearest that a trajectory comes, between samples too.

    Attributes:
        margin: Smallest margin found [m]; below 0 where it is not allowed.
        time: When [s].
        name: Name of the row.
        bound: Proved: no margin is below this at any time [m].
        kept: Distance at a margin of 0 [m].
    """

    margin: float
    time: float
    name: str
    bound: float
    kept: float = 0.0

    @property
    def distance(self) -> float:
        """Smallest distance found [m]."""
        return self.margin + self.kept

    @property
    def collides(self) -> bool:
        """Whether bodies touch, or a point leaves its region, whatever distance was to be kept."""
        return self.distance < -2 * RESOLUTION

    @property
    def allowed(self) -> bool:
        """Whether no margin is anywhere more than twice the resolution, 1 mm, below 0."""
        return self.bound >= -2 * RESOLUTION


@dataclass(frozen=True, eq=False)
class Clearance(ABC):
    """Margins that must stay at or above 0; m rows, one for each thing to keep clear of."""

    @property
    @abstractmethod
    def names(self) -> list[str]:
        """What each row keeps apart, or inside."""

    @property
    def kept(self) -> float:
        """Distance at a margin of 0 [m]."""
        return 0.0

    @abstractmethod
    def margins(self, position: np.ndarray) -> np.ndarray:
        """Margin at positions of shape (t, n) [rad] or [m]; shape (t, m) [m]."""

    @abstractmethod
    def gradient(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Margins, shape (t, m) [m], and their change with each joint, shape (t, m, n) [m/rad]."""

    @abstractmethod
    def reach(self, travel: np.ndarray) -> np.ndarray:
        """The most that each margin can change a unit of each joint's motion, shape (m, n) [m/rad].

        Args:
            travel: Largest distance from zero of the joints that slide, shape (n,) [m].
        """

    def some_margins(self, position: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """The `wanted` margins, a bool of shape (t, m), and infinity elsewhere; shape (t, m) [m]."""
        return np.where(wanted, self.margins(position), np.inf)

    def worst(self, trajectory: Trajectory) -> Approach:
        """The nearest approach on a trajectory, proved for every time."""
        return nearest(self, trajectory)._replace(kept=self.kept)


def nearest_words(approaches: Sequence[Approach]) -> str:
    """How near a motion comes to what it must keep clear of, in words; empty if to nothing."""
    return "; ".join(
        f"{one.name} {1e3 * one.distance:.0f} mm at {one.time:.1f} s" for one in approaches if one.name
    )


def beyond_words(approaches: Sequence[Approach]) -> list[str]:
    """What a motion comes too near to, a sentence each."""
    return [
        f"{one.name}: {1e3 * one.distance:.0f} mm at {one.time:.2f} s; {1e3 * one.kept:.0f} mm must be kept"
        for one in approaches
        if not one.allowed
    ]


FIRST_STEP = 0.1
"""Time between the first samples [s]; where that is too wide they are halved, where not it is saved."""
SHARE = 0.1
"""Of a large margin, how much may be missed: 9 cm of room for 10 is as good an answer."""


def nearest(clearance: Clearance, trajectory: Trajectory) -> Approach:
    """Smallest margin by branch and bound over time.

    While a joint travels by s, a margin changes by at most reach times s. Between two samples with
    margins a and b it is therefore never below (a + b - sum of reach times travel) / 2. Intervals where
    that does not settle the matter are halved, each for the rows that are still open.
    """
    names = clearance.names
    if not names:
        return Approach(np.inf, 0.0, "", np.inf)
    bounds = _Bounds.of(clearance, trajectory)
    count = int(np.ceil(trajectory.duration / FIRST_STEP)) + 1
    states = trajectory.at(np.linspace(0.0, trajectory.duration, max(count, 2)))
    samples = _Ends.of(states, clearance.margins(states.position))
    found = samples.lowest(names)
    left, right = samples.rows(slice(0, -1)), samples.rows(slice(1, None))
    while True:
        lowest = bounds.lowest(left, right)
        is_open = lowest < found.margin - max(RESOLUTION, SHARE * found.margin)
        found = found._replace(bound=min(found.bound, float(np.min(lowest[~is_open], initial=np.inf))))
        left, right = left.take(is_open), right.take(is_open)
        if not len(left.time):
            return found
        states = trajectory.at(0.5 * (left.time + right.time))
        wanted = np.isfinite(left.margin)
        middle = _Ends.of(states, clearance.some_margins(states.position, wanted))
        bound = min(found.bound, float(np.min(middle.margin)))
        found = min(found, middle.lowest(names))._replace(bound=bound)
        left, right = left.join(middle), middle.join(right)


class _Ends(NamedTuple):
    """One end of k intervals: time (k,), speed (k, n), margin (k, m), infinite where it is settled."""

    time: np.ndarray
    speed: np.ndarray
    margin: np.ndarray

    @classmethod
    def of(cls, states: States, margin: np.ndarray) -> "_Ends":
        # a margin that could not be measured counts as none at all
        return cls(states.time, np.abs(states.velocity), np.where(np.isnan(margin), -np.inf, margin))

    def lowest(self, names: list[str]) -> Approach:
        """The smallest margin, as far as these samples show."""
        row, column = np.unravel_index(np.argmin(self.margin), self.margin.shape)
        smallest = float(self.margin[row, column])
        return Approach(smallest, float(self.time[row]), names[column], smallest)

    def rows(self, kept: slice | np.ndarray) -> "_Ends":
        return _Ends(*(part[kept] for part in self))

    def take(self, is_open: np.ndarray) -> "_Ends":
        """The intervals with an open row."""
        kept = np.any(is_open, axis=1)
        return _Ends(self.time, self.speed, np.where(is_open, self.margin, np.inf)).rows(kept)

    def join(self, other: "_Ends") -> "_Ends":
        return _Ends(*(np.concatenate(pair) for pair in zip(self, other, strict=True)))


class _Bounds(NamedTuple):
    """What a whole trajectory keeps to.

    Attributes:
        reach: Shape (m, n) [m/rad].
        velocity: Largest speed of each joint, shape (n,) [rad/s].
        acceleration: Largest acceleration either way, shape (n,) [rad/s^2].
    """

    reach: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray

    @classmethod
    def of(cls, clearance: Clearance, trajectory: Trajectory) -> "_Bounds":
        extremes = trajectory.extremes()
        position, velocity, acceleration = (
            np.maximum(np.abs(found.lower), np.abs(found.upper)) for found in extremes[:3]
        )
        return cls(clearance.reach(position), velocity, acceleration)

    def lowest(self, left: _Ends, right: _Ends) -> np.ndarray:
        """No margin is below this between the ends, shape (k, m) [m]."""
        step = (right.time - left.time)[:, None]
        # speed at either end plus acceleration times time since; the smaller of the two, integrated
        from_ends = 0.5 * step * (left.speed + right.speed) + 0.25 * step**2 * self.acceleration
        travel = np.minimum(self.velocity * step, from_ends)
        return 0.5 * (left.margin + right.margin - travel @ self.reach.T)
