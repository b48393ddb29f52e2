"""One start of the optimisation: sequential quadratic programming with exact gradients.

The solver is SciPy's SLSQP, which handles the thousands of rows of a sampled limit in milliseconds. What it
has found so far is kept at every step, so that there is an answer whenever it is stopped.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import minimize

from .problem import Objective, Problem

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
    """Time is up, or somebody asked."""


@dataclass
class Search:
    """What one start found.

    Attributes:
        unknowns: The best that keeps to the bounds at all samples, shape (k n,); None if nothing did.
        value: Of the last objective there.
        history: Seconds since the start and best value so far.
        evaluations: Of objectives.
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
) -> Search:
    """Minimise a problem's objectives one after the other from a start, shape (k n,).

    Args:
        problem: Objectives and bounds.
        start: Unknowns to begin with; they need not keep to the bounds.
        seconds: Time after which it ends with what there is [s].
        stop: Asked at every step whether to end.
        report: Called whenever something better is found.
    """
    search, begun, last = Search(), time.monotonic(), problem.objectives[-1]
    margins, unknowns = _Remembered(problem.margins), np.array(start)

    def note(at: np.ndarray) -> None:
        """Keep what is best by the last objective; end when asked."""
        if np.min(margins(at)[0]) >= -TOLERANCE:
            value = last.value(problem.basis.motion(problem.coefficients(at)))
            if value < search.value:
                search.unknowns, search.value = at.copy(), value
                search.history.append((time.monotonic() - begun, value))
                report(search)
        if time.monotonic() - begun > seconds or stop():
            raise _Stopped

    try:
        note(unknowns)
        for objective in problem.objectives:
            steps = LAST_STEPS if objective is last else STEPS
            unknowns = _minimise(problem, objective, margins, unknowns, note, search, steps)
    except (_Stopped, KeyboardInterrupt):  # in a process of its own, or at the keyboard
        pass
    return search


def _minimise(
    problem: Problem,
    objective: Objective,
    margins: "_Remembered",
    start: np.ndarray,
    note: Callable[[np.ndarray], None],
    search: Search,
    steps: int,
) -> np.ndarray:
    """Minimum of one objective; what `note` is given is every iterate."""

    def value(at: np.ndarray) -> tuple[float, np.ndarray]:
        search.evaluations += 1
        return problem.value(at, objective)

    rows = {"type": "ineq", "fun": lambda at: margins(at)[0], "jac": lambda at: margins(at)[1]}
    options = {"maxiter": steps, "ftol": GAIN}
    found = minimize(
        value, start, jac=True, method="SLSQP", constraints=[rows], options=options, callback=note
    )
    return np.asarray(found.x) if np.all(np.isfinite(found.x)) else start


class _Remembered:
    """A function of one array that keeps its last result: margins and their slopes are asked for in turn."""

    def __init__(self, function: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]) -> None:
        self._function, self._at = function, np.empty(0)
        self._result = (np.empty(0), np.empty(0))

    def __call__(self, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if not np.array_equal(at, self._at):
            self._at, self._result = at.copy(), self._function(at)
        return self._result
