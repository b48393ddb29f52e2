"""One start of the optimization: a problem's objectives, minimized one after the other within a budget.

The best solution so far is stored at every step, so that there is a result whenever the search is stopped.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from .problem import Problem
from .sqp import Function, minimize


class Budget:
    """Time that a start may use [s], from when it is made; the start ends earlier if `stop` says so."""

    offer = 0.3
    """Initial guess of the cost of bringing a series inside all limits, in the unit of the budget."""

    def __init__(self, amount: float = np.inf, stop: Callable[[], bool] = lambda: False) -> None:
        self.amount, self.stop = amount, stop
        self._begun = time.monotonic()

    @property
    def used(self) -> float:
        """What has been used so far."""
        return time.monotonic() - self._begun

    def iterate(self) -> None:
        """Count an iteration."""

    def deliver(self) -> None:
        """Count a series brought inside all limits."""


class IterationBudget(Budget):
    """Iterations that a start may use: a slow computer then does the same work as a fast computer."""

    offer = 10.0
    used = 0.0

    def iterate(self) -> None:
        self.used += 1.0

    def deliver(self) -> None:
        self.used += self.offer


TOLERANCE = 0.01
"""Violation of a bound, as a share of its room, up to which a sample counts as feasible; the exact check
afterwards removes it, together with the few percent that a series rises between samples."""
STEPS = 150
"""Maximum iterations of an approximation; beyond them, the next objective gains more."""
LAST_STEPS = 400
"""Maximum iterations of the last smooth objective, which nearly always ends earlier by `GAIN`."""
ROUGH = 1e-3
"""Decrease of an approximation, a logarithm, below which the search moves on to the next objective."""
GAIN = 1e-4
"""Decrease of the last objective below which the search ends: one or two percent more would take as long
again, and another start gains more."""


class _Stopped(Exception):
    """The budget is used up, or a stop was requested."""


@dataclass
class Search:
    """Result of one start."""

    curvature: np.ndarray  # learned Hessian of the Lagrangian at the end, shape (k n, k n)
    # Best unknowns that keep the bounds at all samples, shape (k n,); None if there are none.
    unknowns: np.ndarray | None = None
    value: float = np.inf  # value of the last objective there


def solve(
    problem: Problem,
    start: np.ndarray,
    budget: Budget | None = None,
    until: float = np.inf,
    report: Callable[[Search], None] = lambda _: None,
    most: int = LAST_STEPS,
    curvature: np.ndarray | None = None,
) -> Search:
    """Minimize a problem's smooth objectives one after the other from a start, shape (k n,).

    Args:
        problem: Objectives and bounds.
        start: Initial unknowns, which need not keep the bounds.
        budget: Budget of the start, whose request to stop is heeded at every step; unlimited by default.
        until: Amount of the budget in use at which the search ends.
        report: Called at every improvement.
        most: Maximum iterations of the last objective.
        curvature: Hessian that an earlier search has learned in the same unknowns.
    """
    budget, margins, unknowns = budget or Budget(), Function(problem.margins), np.array(start)
    search = Search(np.eye(len(unknowns)) if curvature is None else curvature)
    values = [Function(partial(problem.value, objective=objective)) for objective in problem.objectives]
    smooth = [value for value, objective in zip(values, problem.objectives, strict=True) if objective.smooth]

    def note(at: np.ndarray) -> None:
        """Store the best unknowns by the last objective; raise to end the search."""
        if np.min(margins.value(at)) >= -TOLERANCE:
            value = values[-1].value(at)
            if value < search.value:
                search.unknowns, search.value = at.copy(), value
                report(search)
        if budget.used > until or budget.stop():
            raise _Stopped

    try:
        note(unknowns)
        for objective in smooth:
            steps, gain = (most, GAIN) if objective is smooth[-1] else (STEPS, ROUGH)
            for iterate in minimize(objective, margins, unknowns, search.curvature, steps, gain):
                budget.iterate()
                unknowns, search.curvature = iterate
                note(unknowns)
    except (_Stopped, KeyboardInterrupt):
        pass
    return search
