"""Excite: the search for the Fourier series that is best for a goal within the limits."""

import os
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..errors import BadLimits, Infeasible
from .delivery import SearchResult, Setting
from .goals import Goal
from .parallel import Report, Stop, run_all
from .solve import Clock, IterationClock
from .start import one_start

PAUSE = 5.0
"""Least time between two progress messages during a search [s]."""
SETTLES = 5.0
"""Time that one start needs on a core to come within a few percent of its final value [s]; with less time per
start there are fewer starts, but at least one per core."""


def excite(
    goal: Goal,
    setting: Setting,
    *,
    starts: int = 4,
    seed: int = 0,
    seconds: float = 60.0,
    iterations: int | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> SearchResult:
    """The best result of several starts, with the options of `plan`.

    Raises:
        BadLimits: The number of starts or iterations or the duration is not positive, or the seed is
            negative.
        Infeasible: No start could be brought inside the limits.
    """
    if starts < 1 or not seconds > 0.0:
        raise BadLimits(f"a search of {starts} starts in {seconds:g} s; both must be above 0")
    if seed < 0:
        raise BadLimits(f"seed: {seed}; it must be 0 or more")
    if iterations is not None:
        if iterations < 1:
            raise BadLimits(f"iterations: {iterations}; it must be 1 or more")
        seconds = np.inf
    tasks = [(goal, *start, iterations) for start in starts_of(setting, starts, seed, seconds)]
    starts = len(tasks)
    results: list[SearchResult] = []
    misses: list[str] = []

    def note(outcome: "SearchResult | str") -> None:
        if isinstance(outcome, str):
            misses.append(outcome)
        else:
            results.append(outcome)
            best = min(results, key=lambda result: result.value)
            progress(
                f"start {len(results) + len(misses)} of {starts}: {goal.words(outcome.value)}, "
                f"best {goal.reached(best.value):.4g}"
            )

    run_all(_run_start, tasks, seconds, note, _throttled(goal, progress))
    if not results:
        raise Infeasible(
            misses[0]
            if misses
            else "the search ended before any start kept to the limits. Try a longer search"
        )
    return min(results, key=lambda result: result.value)


def starts_of(setting: Setting, starts: int, seed: int, seconds: float) -> list[tuple[Setting, int]]:
    """Setting and seed of each start: as many as can converge in the time, and at least one per core.

    The first two starts have the first period, and the next ones take the other periods in turn. The first
    period is the longest and nearly always the best.
    """
    cores, periods = os.cpu_count() or 1, setting.periods
    count = min(starts, max(cores, int(min(seconds * cores / SETTLES, starts))))
    places = [max(place - 1, 0) % len(periods) for place in range(count)]
    return [(replace(setting, periods=(periods[k],)), seed + n) for n, k in enumerate(places)]


def _throttled(goal: Goal, progress: Callable[[str], None]) -> Callable[[float], None]:
    """A callback that passes on values that improve on all before, at most once per `PAUSE`."""
    best, last = np.inf, time.monotonic()

    def receive(value: float) -> None:
        nonlocal best, last
        best, better = min(best, value), value < best
        if better and time.monotonic() - last > PAUSE:
            last = time.monotonic()
            progress(f"searching: {goal.words(best)} so far")

    return receive


def _run_start(
    goal: Goal,
    setting: Setting,
    seed: int,
    iterations: int | None,
    seconds: float,
    stop: Stop,
    report: Report,
) -> "SearchResult | str":
    """Run one start, in this process or another."""
    clock = Clock() if iterations is None else IterationClock()
    return one_start(goal, setting, seed, iterations or seconds, stop, report, clock)
