"""Setting and result of a search, and the delivery of its best series, shrunk inside all limits."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Approach, Clearance
from ..errors import Infeasible
from ..families.fourier import Fourier
from ..limits.check import Violation, check
from ..limits.usable_limits import LIMIT_FIELDS, ranges
from .goals import Goal
from .problem import Basis, Problem
from .solve import Budget, Search
from .torque_bound import TorqueBound, share_beyond, with_own_factor
from .torque_spread import TorqueSpread


@dataclass(frozen=True, eq=False)
class Setting:
    """Constraints and shape of the trajectories to search."""

    limits: Limits  # limits, finite for position, velocity, acceleration and jerk
    harmonics: int = 12  # number of harmonics
    periods: tuple[float, ...] = (10.0,)  # base periods that the starts take in turn [s]
    clearances: Sequence[Clearance] = ()  # collisions and regions
    series: int = 1  # number of trajectories that are planned together
    tick: float = 0.002  # sampling period of the controller [s]; a base period is a multiple of it


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of one start, after the exact check."""

    series: tuple[Fourier, ...]  # the trajectories
    value: float  # value of the goal, at samples `FINE` apart
    seed: int  # seed of this start
    # Time [s] and value of each deliverable intermediate result.
    history: list[tuple[float, float]] = field(default_factory=list)
    # Uncertainty of the torque, with the factor by which the series keep to the limits.
    spread: TorqueSpread | None = None


FINE = 0.01
"""Sampling period for the value of the result, with friction of the model [s]: a condition number is within
0.1 % of that at 0.5 ms, for periods from 2 s."""
WIDER = 1.15
"""Factor by which a torque band widens while too many arms exceed a torque limit."""
NARROWEST = 0.25
"""Least share of the widest band after the first widening: the band before may have zero width."""
ASIDE = 0.1
"""Share of the search's budget that is spent on deliverable intermediate results."""


class Delivery:
    """The best of the series that a search offers, each brought inside all limits.

    `report` is called with each value that improves on all before.
    """

    def __init__(
        self, goal: Goal, setting: Setting, basis: Basis, budget: Budget, report: Callable[[float], None]
    ) -> None:
        self._goal, self._setting, self._basis, self._report = goal, setting, basis, report
        self._objective = goal.objectives(setting.limits, 0.0)[-1]
        self._budget = budget
        self.takes = budget.offer  # cost of the last `offer`, in the unit of the budget
        self._aside = 0.0  # cost of all offers
        self._best: SearchResult | None = None
        self._miss = ""  # why no offered series fits inside the limits; empty once one does
        self._history: list[tuple[float, float]] = []

    def offer(self, coefficients: np.ndarray) -> None:
        """Bring series inside all limits, and store them if they are the best."""
        begun = self._budget.used
        try:
            feasible, spread = self._feasible(coefficients)
        except Infeasible as reason:
            self._miss = "" if self._best else str(reason)
            return
        finally:
            self._budget.deliver()
            self.takes = self._budget.used - begun
            self._aside += self.takes
        value = self._objective.value(fine_motion(feasible))
        if self._best is None or value < self._best.value:
            self._best, self._miss = SearchResult(feasible, value, 0, spread=spread), ""
            self._history.append((self._budget.used, value))
            self._report(value)

    def _feasible(self, coefficients: np.ndarray) -> tuple[tuple[Fourier, ...], TorqueSpread | None]:
        """Series inside all limits, with a torque band wide enough for the required share of sampled arms."""
        setting, goal = self._setting, self._goal
        while True:
            feasible = tuple(
                shrink_inside(series, goal, setting.limits, setting.clearances, setting.tick)
                for series in self._basis.fourier(coefficients)
            )
            spread = goal.spread
            if spread is None or spread.factor >= spread.widest:
                return feasible, spread
            shares = [share_beyond(goal, series.every(FINE), setting.limits.torque) for series in feasible]
            if max(shares) <= 1.0 - spread.share:
                return feasible, spread
            wider = max(WIDER * spread.factor, NARROWEST * spread.widest)
            goal = goal.with_spread(replace(spread, factor=min(wider, spread.widest)))

    def narrowed(self) -> tuple[Goal, bool]:
        """Set the torque band to what the best motion needs; return the goal, and whether it is narrower."""
        before = self._goal.spread
        if before is None or self._best is None:
            return self._goal, False
        states = self._best.series[0].every(FINE)
        self._goal = with_own_factor(self._goal, states, self._setting.limits.torque)
        assert self._goal.spread is not None
        return self._goal, self._goal.spread.factor < before.factor

    def offer_callback(self, problem: Problem) -> Callable[[Search], None]:
        """A callback that offers improvements of a search, within a share `ASIDE` of its budget."""

        def receive(search: Search) -> None:
            if search.unknowns is not None and self._aside + self.takes <= ASIDE * self._budget.used:
                self.offer(problem.coefficients(search.unknowns))

        return receive

    def best(self, seed: int) -> "SearchResult | str":
        """The best result, or why there is none."""
        return replace(self._best, seed=seed, history=self._history) if self._best else self._miss


def fine_motion(series: Sequence[Fourier]) -> Motion:
    """The motions of all series at samples `FINE` apart, joined into one."""
    instants = np.arange(0.0, series[0].period, FINE)
    motions = [fourier.at(instants).motion() for fourier in series]
    states = [(motion.position, motion.velocity, motion.acceleration) for motion in motions]
    position, velocity, acceleration = (np.concatenate(parts) for parts in zip(*states, strict=True))
    return Motion.of(np.arange(len(position)) * FINE, position, velocity, acceleration)


STEP = 0.99
"""Factor of the first step if no ratio gives the excess, and relative precision of the largest feasible
excursion. Each further step squares the factor."""
LEAST = 0.2
"""Share of the excursion at which the search ends as infeasible."""
MOST = 10
"""Maximum number of steps by ratios: each brings its joint inside, and more would not help."""


Excess = Sequence[Violation] | Sequence[Approach]
"""Violations of the limits, or else the approaches that are too near; empty for a motion inside."""


def inside_kinematics(series: Fourier, limits: Limits, share: float = 1.0) -> Fourier:
    """The series with each joint's excursion scaled to `share` of what its tightest limit allows."""
    room = []
    for (name, (lower, upper)), reached in zip(ranges(limits).items(), series.extremes(), strict=True):
        about = series.centre if name == "position" else 0.0
        room += [(upper - about) / (reached.upper - about), (lower - about) / (reached.lower - about)]
    return series.scaled(share * np.min(room, axis=0))


def violations_of(series: Fourier, goal: Goal, limits: Limits, tick: float) -> list[Violation]:
    """Violations of the limits by a series, between samples too, in every run of the goal."""
    bound = TorqueBound(goal.model, limits.torque, goal.payloads, goal.spread)
    return [v for payload in goal.payloads for v in check(series, limits, tick, bound.of(payload))]


def tightened(limits: Limits, violations: Sequence[Violation]) -> Limits:
    """Limits tightened by each excess: rates and torques by its share, positions by its amount."""
    changed = {f.name: np.array(getattr(limits, f.name)) for f in fields(limits)}
    for kind, joint, _, value, limit in violations:
        quantity = "position" if kind == "stop" else kind
        if quantity not in LIMIT_FIELDS:  # not finite
            continue
        lower, upper = LIMIT_FIELDS[quantity]
        bound = changed[lower if value < limit else upper]
        if quantity == "position":
            bound[joint] -= value - limit
        else:
            bound[joint] *= limit / value
    return replace(limits, **changed)


def shrink_inside(
    series: Fourier, goal: Goal, limits: Limits, clearances: Sequence[Clearance], tick: float
) -> Fourier:
    """The series, scaled down until it keeps every limit at all times.

    Raises:
        Infeasible: Not even a small motion about its center keeps to the limits.
    """

    def excess(candidate: Fourier) -> Excess:
        approaches = (clearance.worst(candidate) for clearance in clearances)
        return violations_of(candidate, goal, limits, tick) or [
            approach for approach in approaches if not approach.allowed
        ]

    for _ in range(MOST):
        shares = _shares(series, beyond := excess(series))
        if np.all(shares == 1.0):
            break
        series = series.scaled(shares)
    if not beyond:
        return series
    step, remaining = STEP, STEP
    while remaining >= LEAST:
        outside, series = series, series.scaled(step)
        beyond = excess(series)
        if not beyond:
            return _largest(outside, step, excess)
        step **= 2
        remaining *= step
    raise Infeasible(_sentence(goal, beyond))


def _largest(outside: Fourier, step: float, excess: Callable[[Fourier], Excess]) -> Fourier:
    """The largest feasible scaling of a series, between `step`, which is feasible, and 1, which is not."""
    fits, beyond = step, 1.0
    while fits < STEP * beyond:
        middle = float(np.sqrt(fits * beyond))
        fits, beyond = (fits, middle) if excess(outside.scaled(middle)) else (middle, beyond)
    return outside.scaled(fits)


def _shares(series: Fourier, excess: Excess) -> np.ndarray:
    """Factor for each joint's excursion that removes its violations, shape (n,); 1 if no ratio gives it.

    No ratio gives it for torque, since the motion of any joint may load this one, and for distances.
    """
    share = np.ones(series.dof)
    for violation in excess:
        if not isinstance(violation, Violation) or violation.kind == "torque":
            continue
        # A position, or the end of a stop, shrinks at least in proportion to its distance from the center.
        is_rate = violation.kind in ("velocity", "acceleration", "jerk")
        about = 0.0 if is_rate else series.centre[violation.joint]
        away = violation.value - about
        ratio = (violation.limit - about) / away if away else 0.0  # a center outside: the joint rests
        share[violation.joint] = min(share[violation.joint], ratio * (1 - 1e-9))
    return np.maximum(share, 0.0)


def _sentence(goal: Goal, excess: Excess) -> str:
    """Why no scaling is feasible."""
    first = excess[0]
    if isinstance(first, Violation):
        robot = goal.model.robot
        violation = first.sentence(robot.joints, np.flatnonzero(~robot.revolute).tolist())
        margin = ""
        if first.kind == "torque" and goal.spread is not None:
            share = 100 * goal.spread.share
            margin = f" (with a margin for {share:g} % of the possible arms; a fit of the arm reduces it)"
        return (
            f"{violation}{margin}, and smaller motions about the same center do not avoid it. "
            "Try a start pose or position limits that do"
        )
    nearest = min(approach for approach in excess if isinstance(approach, Approach))
    return (
        f"{nearest.name}: {1e3 * nearest.margin:.0f} mm of room at {nearest.time:.2f} s, and smaller motions "
        "about the same center have no more. Try a start pose away from it"
    )
