"""Clearance: margins to collision and to the walls of regions, and positions that keep them."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Robot

from ..errors import Infeasible
from ..trajectory import States, Trajectory

RESOLUTION = 0.5e-3
"""Amount by which the true smallest margin may be below the computed one [m]: far below a mesh's error."""


class Approach(NamedTuple):
    """The nearest approach of a trajectory, between samples too."""

    margin: float  # smallest margin found [m]; negative if it is not allowed
    time: float  # time of the nearest approach [s]
    name: str  # name of the row
    bound: float  # proven lower bound of all margins at all times [m]
    required_distance: float = 0.0  # distance at a margin of 0 [m]

    @property
    def distance(self) -> float:
        """Smallest distance found [m]."""
        return self.margin + self.required_distance

    @property
    def collides(self) -> bool:
        """Whether bodies touch, or a point leaves its region, regardless of the required distance."""
        return self.distance < -2 * RESOLUTION

    @property
    def allowed(self) -> bool:
        """Whether no margin falls more than twice the resolution, 1 mm, below 0."""
        return self.bound >= -2 * RESOLUTION


@dataclass(frozen=True, eq=False)
class Clearance(ABC):
    """Margins that must stay at or above 0, in m rows, one for each pair of bodies or wall."""

    @property
    @abstractmethod
    def names(self) -> list[str]:
        """Name of each row."""

    @property
    def required_distance(self) -> float:
        """Distance at a margin of 0 [m]."""
        return 0.0

    @abstractmethod
    def margins(self, position: np.ndarray) -> np.ndarray:
        """Margins, shape (t, m) [m], at positions of shape (t, n) [rad] or [m]."""

    @abstractmethod
    def gradient(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Margins, shape (t, m) [m], and their derivatives by joint position, shape (t, m, n) [m/rad]."""

    @abstractmethod
    def reach(self, travel: np.ndarray) -> np.ndarray:
        """Largest change of each margin per unit of each joint's motion, shape (m, n) [m/rad].

        `travel` is the largest distance from zero of the prismatic joints, shape (n,) [m].
        """

    def some_margins(self, position: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """Margins where `wanted`, bool of shape (t, m), and infinity elsewhere; shape (t, m) [m]."""
        return np.where(wanted, self.margins(position), np.inf)

    def worst(self, trajectory: Trajectory) -> Approach:
        """The nearest approach of a trajectory, with a bound proven for all times."""
        return nearest(self, trajectory)._replace(required_distance=self.required_distance)


def nearest_words(approaches: Sequence[Approach]) -> str:
    """The nearest approaches of a motion in words; empty if nothing must be kept clear of."""
    return "; ".join(
        f"{approach.name} {1e3 * approach.distance:.0f} mm at {approach.time:.1f} s"
        for approach in approaches
        if approach.name
    )


def beyond_words(approaches: Sequence[Approach]) -> list[str]:
    """A sentence for each approach that is too near."""
    return [
        f"{approach.name}: {1e3 * approach.distance:.0f} mm at {approach.time:.2f} s; at least "
        f"{1e3 * approach.required_distance:.0f} mm are required"
        for approach in approaches
        if not approach.allowed
    ]


FIRST_STEP = 0.1
"""Interval between the first samples [s]; intervals that are too wide are halved."""
SHARE = 0.1
"""Share of a large margin by which it may be wrong: 9 cm instead of 10 is as good an answer."""


def nearest(clearance: Clearance, trajectory: Trajectory) -> Approach:
    """Smallest margin by branch and bound over time.

    While a joint travels by s, a margin changes by at most reach times s. Between two samples with margins a
    and b, it is therefore never below (a + b - sum of reach times travel) / 2. Intervals for which this bound
    is not sufficient are halved, for their open rows only.
    """
    names = clearance.names
    if not names:
        return Approach(np.inf, 0.0, "", np.inf)
    lowest_between = _lowest_between(clearance, trajectory)
    count = int(np.ceil(trajectory.duration / FIRST_STEP)) + 1
    states = trajectory.at(np.linspace(0.0, trajectory.duration, max(count, 2)))
    samples = _Ends.of(states, clearance.margins(states.position))
    smallest = samples.lowest(names)
    left, right = samples.rows(slice(0, -1)), samples.rows(slice(1, None))
    while True:
        lowest = lowest_between(left, right)
        is_open = lowest < smallest.margin - max(RESOLUTION, SHARE * smallest.margin)
        proven = float(np.min(lowest[~is_open], initial=np.inf))
        smallest = smallest._replace(bound=min(smallest.bound, proven))
        left, right = left.take(is_open), right.take(is_open)
        if not len(left.time):
            return smallest
        states = trajectory.at(0.5 * (left.time + right.time))
        wanted = np.isfinite(left.margin)
        middle = _Ends.of(states, clearance.some_margins(states.position, wanted))
        bound = min(smallest.bound, float(np.min(middle.margin)))
        smallest = min(smallest, middle.lowest(names))._replace(bound=bound)
        left, right = left.join(middle), middle.join(right)


class _Ends(NamedTuple):
    """One end of k intervals: time (k,), speed (k, n) and margin (k, m), infinite for rows that are done."""

    time: np.ndarray
    speed: np.ndarray
    margin: np.ndarray

    @classmethod
    def of(cls, states: States, margin: np.ndarray) -> "_Ends":
        # a margin that could not be computed counts as minus infinity
        return cls(states.time, np.abs(states.velocity), np.where(np.isnan(margin), -np.inf, margin))

    def lowest(self, names: list[str]) -> Approach:
        """The smallest margin of these samples."""
        row, column = np.unravel_index(np.argmin(self.margin), self.margin.shape)
        smallest = float(self.margin[row, column])
        return Approach(smallest, float(self.time[row]), names[column], smallest)

    def rows(self, selected: slice | np.ndarray) -> "_Ends":
        return _Ends(*(part[selected] for part in self))

    def take(self, is_open: np.ndarray) -> "_Ends":
        """The intervals with an open row."""
        selected = np.any(is_open, axis=1)
        return _Ends(self.time, self.speed, np.where(is_open, self.margin, np.inf)).rows(selected)

    def join(self, other: "_Ends") -> "_Ends":
        return _Ends(*(np.concatenate(pair) for pair in zip(self, other, strict=True)))


def _lowest_between(clearance: Clearance, trajectory: Trajectory) -> Callable[[_Ends, _Ends], np.ndarray]:
    """Function of both ends of intervals: lower bounds of the margins between them, shape (k, m) [m]."""
    position, velocity, acceleration = (reached.largest for reached in trajectory.extremes()[:3])
    reach = clearance.reach(position)

    def lowest(left: _Ends, right: _Ends) -> np.ndarray:
        step = (right.time - left.time)[:, None]
        # speed at either end plus acceleration times elapsed time; the smaller of the two, integrated
        from_ends = 0.5 * step * (left.speed + right.speed) + 0.25 * step**2 * acceleration
        travel = np.minimum(velocity * step, from_ends)
        return 0.5 * (left.margin + right.margin - travel @ reach.T)

    return lowest


WITHOUT_LIMITS = (np.pi, 1.0)
"""Range either way of a revolute joint without limits, a full turn [rad], and of a prismatic one, 1 m."""
TRIED = 2000
"""Number of random positions: a set of one percent of all positions is missed once in 5e8 tries."""
MENDED = 10
"""Number of nearest misses that are moved along the gradient, for regions that few random positions hit."""
STEPS = 60
"""Number of steps of each; Gauss-Newton comes close in about ten."""


def random_positions(robot: Robot, count: int, seed: int = 0) -> np.ndarray:
    """Uniformly distributed positions within the position limits, shape (count, n) [rad] or [m]."""
    lower, upper = _ends(robot)
    return np.random.default_rng(seed).uniform(lower, upper, (count, robot.dof))


def _ends(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Finite position limits."""
    wide = np.where(robot.revolute, *WITHOUT_LIMITS)
    lower, upper = robot.limits.position_lower, robot.limits.position_upper
    one_sided = np.isfinite(lower) != np.isfinite(upper)
    low = np.where(np.isfinite(lower), lower, np.where(one_sided, upper - 2 * wide, -wide))
    return low, np.where(np.isfinite(upper), upper, np.where(one_sided, lower + 2 * wide, wide))


def clear_position(robot: Robot, clearances: Sequence[Clearance], seed: int = 0) -> np.ndarray:
    """The position with the largest smallest margin that was found, shape (n,) [rad] or [m].

    Raises:
        Infeasible: No position keeps all clearances; the message names those that the best one violates.
    """
    position = random_positions(robot, TRIED, seed)
    worst = _worst(clearances, position)
    if np.max(worst) < 0:
        lower, upper = _ends(robot)
        position = position[np.argsort(worst)[-MENDED:]]
        for _ in range(STEPS):
            position = np.clip(position + _step(clearances, position), lower, upper)
            worst = _worst(clearances, position)
            if np.max(worst) >= 0:
                break
    best = position[np.argmax(worst)]
    if np.max(worst) < 0:
        raise Infeasible(_miss(robot, clearances, best))
    return best


def _worst(clearances: Sequence[Clearance], position: np.ndarray) -> np.ndarray:
    """Smallest of all margins at each position, shape (t,) [m]."""
    margins = [clearance.margins(position) for clearance in clearances]
    return np.min(np.concatenate([np.full((len(position), 1), np.inf), *margins], axis=1), axis=1)


def _step(clearances: Sequence[Clearance], position: np.ndarray) -> np.ndarray:
    """Gauss-Newton step toward margins of 5 mm, shape (t, n)."""
    gradients = [clearance.gradient(position) for clearance in clearances]
    margin = np.concatenate([margins for margins, _ in gradients], axis=1)
    slope = np.concatenate([slopes for _, slopes in gradients], axis=1)
    missing = np.maximum(5e-3 - margin, 0.0)
    slope = slope * (missing > 0)[:, :, None]
    # damped by 5 cm per radian, so that rows with small slopes cause no large steps
    square = slope @ np.swapaxes(slope, 1, 2) + 0.05**2 * np.eye(margin.shape[1])
    weight = np.linalg.solve(square, missing[:, :, None])
    return (np.swapaxes(slope, 1, 2) @ weight)[:, :, 0]


def _miss(robot: Robot, clearances: Sequence[Clearance], position: np.ndarray) -> str:
    """Message that names the margins that the best position violates."""
    names = [name for clearance in clearances for name in clearance.names]
    margins = np.concatenate([clearance.margins(position[None])[0] for clearance in clearances])
    misses = [f"{name} by {-margin:.4g} m" for name, margin in zip(names, margins, strict=True) if margin < 0]
    where = ", ".join(f"{joint} {x:.3g}" for joint, x in zip(robot.joints, position, strict=True))
    return (
        f"{robot.name}: no position within the joint limits keeps all clearances. The best of {TRIED} random "
        f"positions, improved, violates {'; '.join(misses)} ({where}). Widen the region, or check its frame, "
        "which is the robot's base, and its units, which are meters"
    )
