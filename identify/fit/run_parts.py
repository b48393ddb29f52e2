"""Parts of runs that are fitted alone, and the conditions in each."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..preparation.prepare import Prepared
from ..recordings.recording import Recording
from .equations import Equations
from .estimators.covariance import BLOCK, FEWEST_BLOCKS

SHORTEST = FEWEST_BLOCKS * BLOCK
"""Least duration of a part [s]: shorter ones have no estimate of their scatter."""
PARTS = 8
"""Number of parts into which few runs are split: six degrees of freedom for a slope."""
SPEED, TIME, TEMPERATURE = "speed", "time", "temperature"
"""Names of conditions: rms velocity [rad/s], minutes since the first run began, temperature [degC]."""
STAMP = "_ns"
"""End of the names of settings that are times of a clock, which are no conditions."""


@dataclass(frozen=True)
class Part:
    """A run or part of a run."""

    run: str  # name of the run
    start: float  # time of its first row [s]
    end: float  # time of its last row [s]
    # Name of a condition -> its mean, one number per joint or one for all joints.
    conditions: dict[str, tuple[float, ...]]


class RunPart(NamedTuple):
    """A part and its rows in the equations."""

    part: Part
    rows: slice


def run_parts(
    used: Sequence[Prepared], recordings: Sequence[Recording], equations: Equations
) -> list[RunPart]:
    """Runs that last `SHORTEST` or longer; few runs are split into up to `PARTS` such parts."""
    begins, settings = _begins(recordings), _settings(recordings)
    parts = []
    for run, run_rows, begin, numbers in zip(used, equations.runs, begins, settings, strict=True):
        time = run.decimated_time
        for first, last in _split(len(time), equations.rate, len(used)):
            start, end = float(time[first]), float(time[last - 1])
            conditions = {name: (value,) for name, value in numbers.items()} | _measured(run, start, end)
            if begin is not None:
                conditions[TIME] = ((begin + 0.5 * (start + end)) / 60,)
            rows = slice(run_rows.start + first, run_rows.start + last)
            parts.append(RunPart(Part(run.name, start, end, conditions), rows))
    return parts


def _split(count: int, rate: float, runs: int) -> Iterator[tuple[int, int]]:
    """First row of each part of a run, and that after its last."""
    number = min(int(count / (SHORTEST * rate)), max(1, PARTS // runs))
    return pairwise(np.linspace(0, count, number + 1).astype(int).tolist() if number else [])


def _measured(run: Prepared, start: float, end: float) -> dict[str, tuple[float, ...]]:
    """Speed, and temperature if it was measured, of each joint between two times."""
    inside = (run.motion.time >= start) & (run.motion.time <= end)
    means = {SPEED: np.sqrt(np.mean(run.motion.velocity[inside] ** 2, axis=0))}
    temperature = run.motion.temperature[inside]
    if np.all(np.any(np.isfinite(temperature), axis=0)):
        means[TEMPERATURE] = np.nanmean(temperature, axis=0)
    return {name: tuple(map(float, values)) for name, values in means.items()}


def _begins(recordings: Sequence[Recording]) -> list[float | None]:
    """Time at which each run began after the first one [s]; None if several runs do not state it."""
    stamps = [run.host_time for run in recordings]
    known = [int(stamp[0]) for stamp in stamps if stamp is not None and len(stamp)]
    if len(known) < len(recordings):
        return [0.0] if len(recordings) == 1 else [None] * len(recordings)
    return [(stamp - min(known)) * 1e-9 for stamp in known]


def _settings(recordings: Sequence[Recording]) -> list[dict[str, float]]:
    """Numbers in the settings of each run, such as a controller's gains, that all state and that differ."""
    numbers = [
        {name: value for name, text in run.settings.items() if (value := _number(text)) is not None}
        for run in recordings
    ]
    names = [
        name
        for name in numbers[0]
        if not name.endswith(STAMP)
        and all(name in run for run in numbers)
        and len({run[name] for run in numbers}) > 1
    ]
    return [{f"setting {name}": run[name] for name in names} for run in numbers]


def _number(text: str) -> float | None:
    """The number that a setting states; None if it states words."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None
