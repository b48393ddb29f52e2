"""Delivery: the best that a search came by, brought inside all limits as it would be handed over."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from exidyn.identification.arm.motion import Motion

from ..errors import Infeasible
from ..families.fourier import Fourier
from .drawn_arms import share_beyond, with_own_factor
from .goals import Goal
from .problem import Basis, Problem
from .setting import Found, Setting
from .shrink import shrink_inside
from .solve import Search
from .torque_spread import TorqueSpread

FINE = 0.01
"""Spacing of samples at which the value of the result is taken, with friction as stated [s]: a condition
number is within 0.1 % of that from samples 0.5 ms apart, with periods from 2 s."""
WIDER = 1.15
"""Factor on a band that lets too many arms beyond a torque limit, until it is wide enough."""
NARROWEST = 0.25
"""Share of the widest band that the first such step comes to at least: a band may have been nothing."""
ASIDE = 0.1
"""Share of the time of a search that goes into what would be delivered if it ended now."""
OFFER = 0.3
"""What it takes to bring a series inside all limits, until the first has shown it [s]."""


class Delivery:
    """The best of the series that a search came by, each brought inside all limits.

    Args:
        goal: What they are for.
        setting: Within what.
        basis: What coefficients mean.
        report: Called with each value that is better than all before.

    Attributes:
        takes: Time of the last `offer` [s].
        miss: Why nothing that was offered fits inside the limits; empty once something does.
    """

    def __init__(self, goal: Goal, setting: Setting, basis: Basis, report: Callable[[float], None]) -> None:
        self._goal, self._setting, self._basis, self._report = goal, setting, basis, report
        self._begun, self._aside = time.monotonic(), 0.0
        self.takes, self.miss = OFFER, ""
        self._best: Found | None = None
        self._history: list[tuple[float, float]] = []
        self._objective = goal.objectives(setting.limits, 0.0)[-1]

    @property
    def seconds(self) -> float:
        """Time since the search began [s]."""
        return time.monotonic() - self._begun

    def offer(self, coefficients: np.ndarray) -> None:
        """Bring series inside all limits, and keep them if they are the best."""
        begun = self.seconds
        try:
            kept, spread = self._kept(coefficients)
        except Infeasible as reason:
            self.miss = "" if self._best else str(reason)
            return
        finally:
            self.takes = self.seconds - begun
            self._aside += self.takes
        value = self._objective.value(fine_motion(kept))
        if self._best is None or value < self._best.value:
            self._best, self.miss = Found(kept, value, 0, spread=spread), ""
            self._history.append((self.seconds, value))
            self._report(value)

    def _kept(self, coefficients: np.ndarray) -> tuple[tuple[Fourier, ...], TorqueSpread | None]:
        """Inside all limits, those of torque for enough of the drawn arms: else with a wider band.

        Raises:
            Infeasible: They do not fit.
        """
        within, goal = self._setting, self._goal
        while True:
            kept = tuple(
                shrink_inside(one, goal, within.limits, within.clearances, within.tick)
                for one in self._basis.fourier(coefficients)
            )
            spread = goal.spread
            if spread is None or spread.factor >= spread.widest:
                return kept, spread
            if all(
                share_beyond(goal, one.every(FINE), within.limits.torque) <= 1.0 - spread.share
                for one in kept
            ):
                return kept, spread
            wider = max(WIDER * spread.factor, NARROWEST * spread.widest)
            goal = goal.with_spread(replace(spread, factor=min(wider, spread.widest)))

    def narrowed(self) -> tuple[Goal, bool]:
        """The goal with a band as the best motion needs it, from now on; and whether it is narrower."""
        before = self._goal.spread
        if before is None or self._best is None:
            return self._goal, False
        states = self._best.series[0].every(FINE)
        self._goal = with_own_factor(self._goal, states, self._setting.limits.torque)
        assert self._goal.spread is not None
        return self._goal, self._goal.spread.factor < before.factor

    def now_and_then(self, problem: Problem) -> Callable[[Search], None]:
        """What a search calls whenever it is better; most of its time must remain its own."""

        def receive(search: Search) -> None:
            if search.unknowns is not None and self._aside + self.takes <= ASIDE * self.seconds:
                self.offer(problem.coefficients(search.unknowns))

        return receive

    def best(self, seed: int) -> "Found | str":
        """The best of all, or why there is none."""
        return replace(self._best, seed=seed, history=self._history) if self._best else self.miss


def fine_motion(series: Sequence[Fourier]) -> Motion:
    """Motions of all series at samples `FINE` apart, one after the other, as one."""
    moments = np.arange(0.0, series[0].period, FINE)
    motions = [one.at(moments).motion() for one in series]
    states = [(motion.position, motion.velocity, motion.acceleration) for motion in motions]
    position, velocity, acceleration = (np.concatenate(parts) for parts in zip(*states, strict=True))
    return Motion.of(np.arange(len(position)) * FINE, position, velocity, acceleration)
