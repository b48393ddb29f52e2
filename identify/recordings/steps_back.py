"""Time that does not go on from one row to the next: why that seems to be, and what to do about it."""

import numpy as np

OFTEN = 3
"""Steps back from which on two sources are asked for."""
SCATTERED = 0.3
"""Share of the late rows that begin a group of them; two sources take turns, a second run is one group."""
JUMP = 10.0
"""Distance between the rows of two sources at one time, over what a joint moves from row to row, at least."""
BEGINNING = 0.05
"""Share of a file in which the rows from before the recorder settled lie."""
ROUNDED = 0.2
"""Share of the steps that are none, from which on stamps have too few digits."""
ROUGHER = 1.5
"""Way from row to row after sorting, over that before, from which on rows were in order."""
CUT = "Time begins anew there: cut the file there, into a run each"
DIGITS = "Stamps have few digits: state the rate of the samples instead (--rate HZ)"
SORT = "Sort the rows by time, or leave out those that repeat a time"
SKIP = "Leave out the first rows (skip_rows, --skip-rows)"


def steps_back(time: np.ndarray) -> np.ndarray:
    """Rows behind which time does not go on, of times (t,)."""
    return np.flatnonzero(np.diff(time) <= 0)


def advice(time: np.ndarray, values: np.ndarray) -> str:
    """What to do about times (t,) that do not increase; values (t, c) tell whether two sources take turns."""
    back = steps_back(time)
    late = _late(time)
    if _take_turns(time, values, late):
        return (
            f"Rows of two sources seem mixed, as of two publishers: {late.sum()} rows are far from those "
            "around them. Leave out those of one"
        )
    if len(back) and back[-1] + 1 < BEGINNING * len(time):
        return SKIP
    steps = np.diff(time)
    if np.any(steps > 0.0) and np.mean(steps == 0.0) > ROUNDED and not np.any(steps < 0.0):
        return DIGITS
    return CUT if _in_order(time, values) else SORT


def _in_order(time: np.ndarray, values: np.ndarray) -> bool:
    """Whether rows, once sorted by time, would jump between values (t, c) more than they do."""
    known = np.isfinite(values).all(axis=0)
    order = np.argsort(time, kind="stable")
    ways = (np.abs(np.diff(rows, axis=0)).sum() for rows in (values[:, known], values[order][:, known]))
    as_they_are, when_sorted = ways
    return bool(when_sorted > ROUGHER * as_they_are)


def _late(time: np.ndarray) -> np.ndarray:
    """Which rows are no later than one before them, bool (t,)."""
    latest = np.maximum.accumulate(np.concatenate([[-np.inf], time[:-1]]))
    return ~(time > latest)


def _take_turns(time: np.ndarray, values: np.ndarray, late: np.ndarray) -> bool:
    """Whether late rows lie between others all the time, and would not fit among them."""
    groups = int(np.sum(late[1:] & ~late[:-1]))
    if groups < OFTEN or groups < SCATTERED * late.sum() or np.sum(~late) < OFTEN:
        return False
    return any(_apart(time, column, late) for column in values.T)


def _apart(time: np.ndarray, column: np.ndarray, late: np.ndarray) -> bool:
    """Whether the late values of one joint are far from what the others have at that time."""
    known = np.isfinite(column) & np.isfinite(time)
    first, second = known & ~late, known & late
    if np.sum(first) < OFTEN or np.sum(second) < OFTEN:
        return False
    usual = float(np.mean(np.abs(np.diff(column[first]))))
    off = np.abs(column[second] - np.interp(time[second], time[first], column[first]))
    return float(np.median(off)) > JUMP * usual > 0.0
