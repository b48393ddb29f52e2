"""Order of the times in a file: consecutive runs, and times that do not increase from one row to the next."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from enum import Enum
from types import MappingProxyType

import numpy as np

from .incomplete_samples import is_number
from .recording import Recording, Signal
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


OFTEN = 3
"""Minimum number of steps back to suspect two sources."""
SCATTERED = 0.3
"""Minimum share of late rows that begin a group; two sources alternate, while a second run is one group."""
JUMP = 10.0
"""Minimum distance between the rows of two sources at one time, over the usual motion from row to row."""
BEGINNING = 0.05
"""Share of a file at its beginning that a recorder may write before it settles."""
ROUNDED = 0.2
"""Share of zero steps above which stamps have too few digits."""
ROUGHER = 1.5
"""Ratio of the distance from row to row after sorting to that before, above which rows were in order."""


class Remedy(Enum):
    """What to do about times that do not increase; the value is the advice."""

    SEPARATE = (
        "Rows of two sources seem mixed, as of two publishers: {} rows are far from those around them. Leave "
        "out those of one"
    )
    SKIP = "Leave out the first {} rows (in Python skip_rows)"
    STATE_RATE = "Stamps have too few digits: the rate of the samples must be known instead"
    ALL_EQUAL = (
        "All times are equal, as large numbers in single precision are: the rate must be known instead"
    )
    CUT = "Time begins anew there: cut the file there, into a run each"
    SORT = "Sort the rows by time"
    LEAVE_OUT = "Leave out the {} rows whose time is not above all times before it"


def steps_back(time: np.ndarray) -> np.ndarray:
    """Rows after which times (t,) do not increase."""
    return np.flatnonzero(np.diff(time) <= 0)


def advice(time: np.ndarray, values: np.ndarray) -> str:
    """Advice about times (t,) that do not increase; values (t, c) show whether two sources alternate."""
    chosen, late = remedy(time, values), _late(time)
    return chosen.value.format(steps_back(time)[-1] + 1 if chosen is Remedy.SKIP else late.sum())


def remedy(time: np.ndarray, values: np.ndarray) -> Remedy:
    """What to do about times (t,) that do not increase, see `advice`."""
    back, late = steps_back(time), _late(time)
    groups = int(np.sum(late[1:] & ~late[:-1]))
    take_turns = groups >= OFTEN and groups >= SCATTERED * late.sum() and np.sum(~late) >= OFTEN
    if take_turns and any(_apart(time, column, late) for column in values.T):
        return Remedy.SEPARATE
    if len(back) and back[-1] + 1 < BEGINNING * len(time):
        return Remedy.SKIP
    steps = np.diff(time)
    if not np.any(steps != 0.0):
        return Remedy.ALL_EQUAL
    if np.mean(steps == 0.0) > ROUNDED and not np.any(steps < 0.0):
        return Remedy.STATE_RATE
    if _in_order(time, values):
        return Remedy.CUT
    # Sorting does not help where times repeat.
    return Remedy.SORT if len(np.unique(time)) == len(time) else Remedy.LEAVE_OUT


def _in_order(time: np.ndarray, values: np.ndarray) -> bool:
    """Whether sorting the rows by time would increase the jumps between values (t, c)."""
    known = np.isfinite(values).all(axis=0)
    order = np.argsort(time, kind="stable")
    distances = (np.abs(np.diff(rows, axis=0)).sum() for rows in (values[:, known], values[order][:, known]))
    unsorted, when_sorted = distances
    return bool(when_sorted > ROUGHER * unsorted)


def _late(time: np.ndarray) -> np.ndarray:
    """Whether rows are not later than all rows before them, bool (t,)."""
    latest_before = np.maximum.accumulate(np.concatenate([[-np.inf], time[:-1]]))
    return ~(time > latest_before)


def _apart(time: np.ndarray, column: np.ndarray, late: np.ndarray) -> bool:
    """Whether the late values of a joint are far from the other values at the same time."""
    known = np.isfinite(column) & np.isfinite(time)
    first, second = known & ~late, known & late
    if np.sum(first) < OFTEN or np.sum(second) < OFTEN:
        return False
    usual = float(np.mean(np.abs(np.diff(column[first]))))
    off = np.abs(column[second] - np.interp(time[second], time[first], column[first]))
    return float(np.median(off)) > JUMP * usual > 0.0
