"""One start of the optimisation: sequential quadratic programming with exact gradients.

The solver is SciPy's SLSQP, which handles the thousands of rows of a sampled limit in milliseconds. What it
has found so far is kept at every step, so that there is an answer whenever it is stopped.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import minimize

from .problem import Problem

TOLERANCE = 0.01
"""Margin by which a sample may miss a bound and still count as kept, as a share of its room; the exact
check afterwards takes it back, with the few per cent that a series rises between samples."""
STEPS = 150
"""Iterations of a stand-in; what it gains after that is less than what the next objective gains."""
LAST_STEPS = 400
"""Iterations of the goal itself: it nearly always ends by `GAIN` before."""
GAIN = 1e-5
"""Change of an objective, a logarithm, at which it is left: a thousandth of a per cent of what it is of."""


class _Stopped(Exception):
    """Time is up, or an end was asked for."""


@dataclass
class Search:
    """What one start found.

    Attributes:
        unknowns: The best that keeps to the bounds at all samples, shape (k n,); None if nothing did.
        value: Value of the last objective there.
        history: Seconds since the start and best value so far.
        evaluations: Evaluations of objectives.
    """

    unknowns: np.ndarray | None = None
    value: float = np.inf
    history: list[tuple[float, float]] = field(default_factory=list)
    evaluations: int = 0


def solve(
    problem: Problem,
    start: np.ndarray,
    seconds: float = np.inf,
    stop: Callable[[], bool] = lambda: False,
    report: Callable[[Search], None] = lambda _: None,
    most: int = LAST_STEPS,
) -> Search:
    """Minimise a problem's objectives one after the other from a start, shape (k n,).

    Args:
        problem: Objectives and bounds.
        start: Unknowns to begin with; they need not keep to the bounds.
        seconds: Time after which it ends with what there is [s].
        stop: Asked at every step whether to end.
        report: Called whenever something better is found.
        most: Steps of the last objective at most.
    """
    search, begun = Search(), time.monotonic()
    margins, unknowns = _Remembered(problem.margins), np.array(start)
    values = [_Remembered(partial(problem.value, objective=one)) for one in problem.objectives]

    def note(at: np.ndarray) -> None:
        """Keep what is best by the last objective; end when asked."""
        if np.min(margins.value(at)) >= -TOLERANCE:
            value = values[-1].value(at)
            if value < search.value:
                search.unknowns, search.value = at.copy(), value
                search.history.append((time.monotonic() - begun, value))
                report(search)
        if time.monotonic() - begun > seconds or stop():
            raise _Stopped

    try:
        note(unknowns)
        for objective in values:
            steps = most if objective is values[-1] else STEPS
            unknowns = _minimise(objective, margins, unknowns, note, search, steps)
    except (_Stopped, KeyboardInterrupt):  # in a process of its own, or at the keyboard
        pass
    return search


def _minimise(
    objective: "_Remembered",
    margins: "_Remembered",
    start: np.ndarray,
    note: Callable[[np.ndarray], None],
    search: Search,
    steps: int,
) -> np.ndarray:
    """Minimum of one objective; what `note` is given is every iterate."""

    def value(at: np.ndarray) -> float:
        search.evaluations += 1
        return objective.value(at)

    rows = {"type": "ineq", "fun": margins.value, "jac": margins.slope}
    options = {"maxiter": steps, "ftol": GAIN}
    found = minimize(
        value, start, jac=objective.slope, method="SLSQP", constraints=[rows], options=options, callback=note
    )
    return np.asarray(found.x) if np.all(np.isfinite(found.x)) else start


class _Remembered:
    """A function of one array and its slope, computed once where value and slope are asked for in turn.

    The solver wants slopes at its iterates alone, and values at every step of its line searches too.
    """

    def __init__(self, function: Callable[[np.ndarray], tuple[Any, Callable[[], np.ndarray]]]) -> None:
        self._function, self._at = function, np.empty(0)

    def value(self, at: np.ndarray) -> Any:
        """Value there."""
        if not np.array_equal(at, self._at):
            self._value, self._slope = self._function(at)
            self._at = at.copy()
        return self._value

    def slope(self, at: np.ndarray) -> np.ndarray:
        """Slope there."""
        self.value(at)
        return self._slope()
