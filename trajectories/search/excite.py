"""Excite: the Fourier series that serves a goal best within the limits."""

import os
import time
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from ..errors import BadLimits, Infeasible
from .goals import Goal
from .parallel import Stop, report, run_all
from .setting import Found, Setting
from .start import one_start

PAUSE = 5.0
"""Between two sentences about a search that runs [s]."""
SETTLES = 5.0
"""What one start needs on a core to come within some per cent of where it ends [s]: with less time for each
there are fewer of them, but one a core."""


def excite(
    goal: Goal,
    setting: Setting,
    *,
    starts: int = 4,
    seed: int = 0,
    seconds: float = 60.0,
    executor: Executor | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Found:
    """The best of several starts.

    Args:
        goal: What the trajectory is for.
        setting: Limits, harmonics, period.
        starts: Random starts at most, with seeds `seed`, `seed` + 1 and so on; they take the periods in
            turn, the first of them twice.
        seed: Seed of the first start.
        seconds: Length of the search [s], not counting the start of its processes.
        executor: Where starts run; a pool of processes unless given.
        progress: Called with a sentence whenever a start ends, and now and then while they run.

    Raises:
        BadLimits: No start, or no time.
        Infeasible: No start could be brought inside the limits.
    """
    if starts < 1 or not seconds > 0.0:
        raise BadLimits(f"a search of {starts} starts in {seconds:g} s; both must be above 0")
    if seed < 0:
        raise BadLimits(f"seed: {seed}; it must be 0 or more")
    tasks = [(goal, *one) for one in starts_of(setting, starts, seed, seconds)]
    starts = len(tasks)
    found: list[Found] = []
    misses: list[str] = []

    def note(outcome: "Found | str") -> None:
        if isinstance(outcome, str):
            misses.append(outcome)
        else:
            found.append(outcome)
            best = min(found, key=lambda one: one.value)
            progress(
                f"start {len(found) + len(misses)} of {starts}: {goal.words(outcome.value)}; "
                f"best {goal.words(best.value)}"
            )

    run_all(_reported, tasks, seconds, executor, note, _now_and_then(goal, progress))
    if not found:
        raise Infeasible(
            misses[0] if misses else "stopped before a start had kept to the limits; give it longer"
        )
    return min(found, key=lambda one: one.value)


def starts_of(setting: Setting, starts: int, seed: int, seconds: float) -> list[tuple[Setting, int]]:
    """Setting and seed of each start: as many as the time brings near to where they end, and one a core.

    The first two have the first of the periods, then come the others in turn. It is the longest, and nearly
    always the best.
    """
    cores = os.cpu_count() or 1
    count, periods = min(starts, max(cores, int(seconds * cores / SETTLES))), setting.periods
    places = [max(place - 1, 0) % len(periods) for place in range(count)]
    return [(replace(setting, periods=(periods[k],)), seed + n) for n, k in enumerate(places)]


def _now_and_then(goal: Goal, progress: Callable[[str], None]) -> Callable[[float], None]:
    """Passes on what a search reports if it is better than all before, but not more often than `PAUSE`."""
    best, last = np.inf, time.monotonic()

    def receive(value: float) -> None:
        nonlocal best, last
        best, better = min(best, value), value < best
        if better and time.monotonic() - last > PAUSE:
            last = time.monotonic()
            progress(f"searching: {goal.words(best)} so far")

    return receive


def _reported(goal: Goal, setting: Setting, seed: int, seconds: float, stop: Stop) -> "Found | str":
    """One start in whatever process it runs."""
    return one_start(goal, setting, seed, seconds, stop, report)
