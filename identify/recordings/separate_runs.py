"""Runs that follow each other in one file: time begins anew there, or is missing for long."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from .recording import Recording, Signal
from .recording_findings import is_number
from .sample_numbers import Motion

SHORTEST = 50
"""Samples of a run, at least; fewer are what a recorder wrote before it settled."""
BACK = 50.0
"""Median periods by which time goes back where a run begins; rows out of order are closer together."""
AROUND = 5
"""Samples before and behind a beginning whose median time is compared."""
PAUSE = 10.0
"""Time without a sample after which another run begins [s]: no recorder that goes on loses so much."""
MANY_PERIODS = 100.0
"""Median periods of such a pause, at least: time may be in another unit than seconds."""
SCRAPS = 0.05
"""Share of the samples in pieces that are no run, at most; two sources that take turns have more of them."""
PART = "part"
"""Setting of a recording that is one of several in a file; its text is which, and where it begins."""


class Part(NamedTuple):
    """One run of a file.

    Attributes:
        recording: The run, its time from its first position on.
        first: Its first row in the file, from 0.
    """

    recording: Recording
    first: int


def separate_runs(
    recording: Recording, place: Callable[[int], str], headings: Mapping[int, str] = MappingProxyType({})
) -> list[Part]:
    """The runs of a recording from one file, each with a warning that says where it begins; or the one.

    Args:
        recording: Its times as in the file.
        place: What a row is called in an error, from its number.
        headings: Rows above which the names of the columns stand again, and where these stand.
    """
    position = recording.signals["position"]
    why = dict.fromkeys(headings, "the names of the columns stand again")
    why |= dict(beginnings(position.time, position.values))
    parts = [range(*ends) for ends in zip([0, *sorted(why)], [*sorted(why), len(position)], strict=True)]
    runs = [part for part in parts if len(part) >= SHORTEST]
    scraps = sum(len(part) for part in parts) - sum(len(part) for part in runs)
    apart = [
        signal for signal in recording.signals.values() if not np.array_equal(signal.time, position.time)
    ]
    if len(runs) < 2 or scraps > SCRAPS * len(position) or apart:
        return [Part(recording, 0)]
    where = "; ".join(f"{why[row]} at {headings.get(row) or place(row)}" for row in sorted(why))
    return [Part(_part(recording, run, k, len(runs), where, scraps), run[0]) for k, run in enumerate(runs, 1)]


def beginnings(time: np.ndarray, values: np.ndarray) -> Iterator[tuple[int, str]]:
    """Rows at which another run begins, and why; a clock that was set in a run is none.

    Args:
        time: Shape (t,) [s].
        values: Positions, shape (t, n).
    """
    if not is_number(time).all():
        return
    steps = np.diff(time)
    period = float(np.median(steps)) if len(steps) else 0.0
    if not period > 0.0:
        return
    motion, values = None, values[:, is_number(values).all(axis=0)]
    for row in np.flatnonzero((steps < -BACK * period) | (steps > max(PAUSE, MANY_PERIODS * period))) + 1:
        # Single stamps that are wrong begin nothing.
        step = np.median(time[row : row + AROUND]) - np.median(time[max(row - AROUND, 0) : row])
        if abs(step) < BACK * period or step * steps[row - 1] < 0.0:
            continue
        motion = motion or Motion.of(values)
        if not motion.goes_on(int(row) - 1):
            yield int(row), "time begins anew" if step < 0 else f"{steps[row - 1]:.0f} s are missing"


def _part(recording: Recording, rows: range, number: int, count: int, where: str, scraps: int) -> Recording:
    """One of several runs in rows of a file; of these, some samples are in none."""
    start = recording.signals["position"].time[rows[0]]
    piece = slice(rows[0], rows[-1] + 1)
    signals = {
        name: Signal(signal.time[piece] - start, signal.values[piece])
        for name, signal in recording.signals.items()
    }
    which = f"run {number} of {count} in the file"
    short = f"; {scraps} samples between them are too few for a run, and left out" if scraps else ""
    part = replace(
        recording,
        name=f"{recording.name}_{number}",
        signals=signals,
        host_time=None if recording.host_time is None else recording.host_time[piece],
        settings={**recording.settings, PART: f"{which}: {where}"},
    )
    return part.with_warnings(f"{where}: this is {which}{short}")
