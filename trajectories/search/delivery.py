"""Setting and result of a search, and the delivery of its best series, brought inside all limits."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..errors import Infeasible
from ..families.fourier import Fourier
from .goals import Goal
from .problem import Basis, Problem
from .shrink import shrink_inside
from .solve import Clock, Search
from .torque_bound import share_beyond, with_own_factor
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

    Attributes:
        takes: Cost of the last `offer`, in the clock's unit.
        miss: Why no offered series fits inside the limits; empty once one does.
    """

    def __init__(
        self,
        goal: Goal,
        setting: Setting,
        basis: Basis,
        report: Callable[[float], None],
        clock: Clock | None = None,
    ) -> None:
        self._goal, self._setting, self._basis, self._report = goal, setting, basis, report
        self._clock = clock or Clock()
        self._start, self._aside = self._clock.now(), 0.0
        self.takes, self.miss = self._clock.offer, ""
        self._best: SearchResult | None = None
        self._history: list[tuple[float, float]] = []
        self._objective = goal.objectives(setting.limits, 0.0)[-1]

    @property
    def used(self) -> float:
        """Budget used since the search began, in the clock's unit."""
        return self._clock.now() - self._start

    def offer(self, coefficients: np.ndarray) -> None:
        """Bring series inside all limits, and store them if they are the best."""
        begun = self.used
        try:
            feasible, spread = self._feasible(coefficients)
        except Infeasible as reason:
            self.miss = "" if self._best else str(reason)
            return
        finally:
            self._clock.deliver()
            self.takes = self.used - begun
            self._aside += self.takes
        value = self._objective.value(fine_motion(feasible))
        if self._best is None or value < self._best.value:
            self._best, self.miss = SearchResult(feasible, value, 0, spread=spread), ""
            self._history.append((self.used, value))
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
            if all(
                share_beyond(goal, series.every(FINE), setting.limits.torque) <= 1.0 - spread.share
                for series in feasible
            ):
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
            if search.unknowns is not None and self._aside + self.takes <= ASIDE * self.used:
                self.offer(problem.coefficients(search.unknowns))

        return receive

    def best(self, seed: int) -> "SearchResult | str":
        """The best result, or why there is none."""
        return replace(self._best, seed=seed, history=self._history) if self._best else self.miss


def fine_motion(series: Sequence[Fourier]) -> Motion:
    """The motions of all series at samples `FINE` apart, joined into one."""
    instants = np.arange(0.0, series[0].period, FINE)
    motions = [fourier.at(instants).motion() for fourier in series]
    states = [(motion.position, motion.velocity, motion.acceleration) for motion in motions]
    position, velocity, acceleration = (np.concatenate(parts) for parts in zip(*states, strict=True))
    return Motion.of(np.arange(len(position)) * FINE, position, velocity, acceleration)
