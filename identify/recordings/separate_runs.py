"""Separation of consecutive runs in one file, where time restarts or has a long gap."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from .recording import Recording, Signal
from .recording_findings import is_number
from .sample_numbers import Motion

SHORTEST = 50
"""Minimum number of samples of a run; a recorder may write fewer before it settles."""
BACK = 50.0
"""Minimum step back of time at the beginning of a run, in median periods; unordered rows are closer."""
AROUND = 5
"""Number of samples before and behind a beginning whose median times are compared."""
PAUSE = 10.0
"""Minimum gap before another run [s]: a recorder does not lose that much during a run."""
MANY_PERIODS = 100.0
"""Minimum gap before another run in median periods, as time may be in another unit than seconds."""
SCRAPS = 0.05
"""Maximum share of the samples in pieces too short for a run; two alternating sources have more."""
PART = "part"
"""Setting of a recording that is one of several in a file; its text names the run and its beginning."""


def separate_runs(
    recording: Recording, place: Callable[[int], str], headings: Mapping[int, str] = MappingProxyType({})
) -> list[tuple[Recording, int]]:
    """Runs of a recording from one file, each with a warning about its beginning; or the only run.

    The time of a run begins at its first position; beside it is the index of its first row in the file.
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
        return [(recording, 0)]
    where = "; ".join(f"{why[row]} at {headings.get(row) or place(row)}" for row in sorted(why))
    return [(_part(recording, run, k, len(runs), where, scraps), run[0]) for k, run in enumerate(runs, 1)]


def beginnings(time: np.ndarray, values: np.ndarray) -> Iterator[tuple[int, str]]:
    """Rows at which another run begins, and the reasons, from times (t,) [s] and positions (t, n).

    Setting a clock during a run does not count.
    """
    if not is_number(time).all():
        return
    steps = np.diff(time)
    period = float(np.median(steps)) if len(steps) else 0.0
    if not period > 0.0:
        return
    motion, values = None, values[:, is_number(values).all(axis=0)]
    for row in np.flatnonzero((steps < -BACK * period) | (steps > max(PAUSE, MANY_PERIODS * period))) + 1:
        # Single wrong stamps are not the beginning of a run.
        step = np.median(time[row : row + AROUND]) - np.median(time[max(row - AROUND, 0) : row])
        if abs(step) < BACK * period or step * steps[row - 1] < 0.0:
            continue
        motion = motion or Motion.of(values)
        if not motion.goes_on(int(row) - 1):
            yield int(row), "time begins anew" if step < 0 else f"{steps[row - 1]:.0f} s are missing"


def _part(recording: Recording, rows: range, number: int, count: int, where: str, scraps: int) -> Recording:
    """Run number `number` of `count` runs in a file; `scraps` is the number of samples in no run."""
    start = recording.signals["position"].time[rows[0]]
    piece = slice(rows[0], rows[-1] + 1)
    signals = {
        name: Signal(signal.time[piece] - start, signal.values[piece])
        for name, signal in recording.signals.items()
    }
    title = f"run {number} of {count} in the file"
    short = f"; {scraps} samples between them are too few for a run, and left out" if scraps else ""
    part = replace(
        recording,
        name=f"{recording.name}_{number}",
        signals=signals,
        host_time=None if recording.host_time is None else recording.host_time[piece],
        settings={**recording.settings, PART: f"{title}: {where}"},
    )
    return part.with_warnings(f"{where}: this is {title}{short}")
