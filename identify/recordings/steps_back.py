"""Times that do not increase from one row to the next: the likely reason, and advice."""

from enum import Enum

import numpy as np

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
    back = steps_back(time)
    if _take_turns(time, values, _late(time)):
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


def _take_turns(time: np.ndarray, values: np.ndarray, late: np.ndarray) -> bool:
    """Whether late rows alternate with the others, and have different values."""
    groups = int(np.sum(late[1:] & ~late[:-1]))
    if groups < OFTEN or groups < SCATTERED * late.sum() or np.sum(~late) < OFTEN:
        return False
    return any(_apart(time, column, late) for column in values.T)


def _apart(time: np.ndarray, column: np.ndarray, late: np.ndarray) -> bool:
    """Whether the late values of a joint are far from the other values at the same time."""
    known = np.isfinite(column) & np.isfinite(time)
    first, second = known & ~late, known & late
    if np.sum(first) < OFTEN or np.sum(second) < OFTEN:
        return False
    usual = float(np.mean(np.abs(np.diff(column[first]))))
    off = np.abs(column[second] - np.interp(time[second], time[first], column[first]))
    return float(np.median(off)) > JUMP * usual > 0.0
