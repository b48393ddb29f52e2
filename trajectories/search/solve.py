"""One start of the optimisation: a problem's objectives, minimised one after the other.

What has been found so far is kept at every step, so that there is an answer whenever it is stopped.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from .problem import Problem
from .sqp import Function, minimise

TOLERANCE = 0.01
"""Margin by which a sample may miss a bound and still count as kept, as a share of its room; the exact
check afterwards takes it back, with the few per cent that a series rises between samples."""
STEPS = 150
"""Iterations of a stand-in; what it gains after that is less than what the next objective gains."""
LAST_STEPS = 400
"""Iterations of the last smooth objective: it nearly always ends by `GAIN` before."""
ROUGH = 1e-3
"""Fall of a stand-in, a logarithm, at which it is left for the next."""
GAIN = 1e-4
"""The same of the last: going on takes as long again for one or two per cent; another start gains more."""


class _Stopped(Exception):
    """Time is up, or an end was asked for."""


@dataclass
class Search:
    """What one start found.

    Attributes:
        curvature: Of the Lagrangian at the end, as learnt, shape (k n, k n).
        unknowns: The best that keeps to the bounds at all samples, shape (k n,); None if nothing did.
        value: Value of the last objective there.
        history: Seconds since the start and best value so far.
    """

    curvature: np.ndarray
    unknowns: np.ndarray | None = None
    value: float = np.inf
    history: list[tuple[float, float]] = field(default_factory=list)


def solve(
    problem: Problem,
    start: np.ndarray,
    seconds: float = np.inf,
    stop: Callable[[], bool] = lambda: False,
    report: Callable[[Search], None] = lambda _: None,
    most: int = LAST_STEPS,
    curvature: np.ndarray | None = None,
) -> Search:
    """Minimise a problem's smooth objectives one after the other from a start, shape (k n,).

    Args:
        problem: Objectives and bounds.
        start: Unknowns to begin with; they need not keep to the bounds.
        seconds: Time after which it ends with what there is [s].
        stop: Asked at every step whether to end.
        report: Called whenever something better is found.
        most: Steps of the last of them at most.
        curvature: As an earlier search has learnt it in the same unknowns.
    """
    begun, margins, unknowns = time.monotonic(), Function(problem.margins), np.array(start)
    search = Search(np.eye(len(unknowns)) if curvature is None else curvature)
    values = [Function(partial(problem.value, objective=one)) for one in problem.objectives]
    smooth = [value for value, one in zip(values, problem.objectives, strict=True) if one.smooth]

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
        for objective in smooth:
            steps, gain = (most, GAIN) if objective is smooth[-1] else (STEPS, ROUGH)
            for iterate in minimise(objective, margins, unknowns, search.curvature, steps, gain):
                unknowns, search.curvature = iterate
                note(unknowns)
    except (_Stopped, KeyboardInterrupt):  # in a process of its own, or at the keyboard
        pass
    return search
