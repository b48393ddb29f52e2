"""Positions at which a register saturates: they stay at the extreme value while the joint moves on."""

import numpy as np

from .recording import Recording
from .recording_findings import is_number

FEWEST = 3
"""Minimum number of consecutive samples at exactly the extreme value; a crest is approached slowly."""
ABRUPT = 4.0
"""Change of speed within one sample, over the joint's usual changes, that no motor can cause."""
APART = (1, 2, 5)
"""Numbers of samples over which speeds are computed: many average noise, few resolve an abrupt stop."""
USUAL = 99.0
"""Percentile of the usual changes of speed."""


def without_saturated(recording: Recording) -> Recording:
    """Recording without samples whose position saturates, and with a warning about each such joint."""
    position = recording.signals["position"]
    valid, warnings = np.ones(len(position), bool), []
    for joint, column in zip(recording.robot.joints, position.values.T, strict=True):
        held = saturated(column)
        for extreme in np.unique(column[held]):
            count = int(np.sum(column[held] == extreme))
            warnings.append(
                f"position: {joint} is held at exactly {extreme:g} in {count} samples, "
                "though it moves fast before and after them: it is clipped there; they are left out"
            )
        valid &= ~held
    if not warnings:
        return recording
    rows = {
        name: valid
        for name, signal in recording.signals.items()
        if np.array_equal(signal.time, position.time)
    }
    return recording.keeping(rows).with_warnings(*warnings)


def saturated(column: np.ndarray) -> np.ndarray:
    """Whether positions (t,) are held at their highest or lowest value by a register and not by a drive."""
    held = np.zeros(len(column), bool)
    if len(column) < 10 * FEWEST or not is_number(column).all():
        return held
    runs = [run for extreme in (column.min(), column.max()) for run in _runs(column == extreme)]
    for apart in APART if runs else ():
        turns = np.abs(column[2 * apart :] - 2 * column[apart:-apart] + column[: -2 * apart])
        for start, stop in runs:  # excludes the stops in question
            turns[max(start - 2 * apart, 0) : stop + 1] = np.nan
        usual = float(np.nanpercentile(turns, USUAL)) if np.isfinite(turns).any() else np.inf
        for start, stop in runs:
            if apart <= start - 1 and stop + apart < len(column):
                steps = column[start - 1] - column[start - 1 - apart], column[stop + apart] - column[stop]
                held[start:stop] |= min(np.abs(steps)) > ABRUPT * usual > 0.0
    return np.isin(column, np.unique(column[held]))  # other samples at that value are clipped too


def _runs(extreme: np.ndarray) -> list[tuple[int, int]]:
    """Beginnings and ends of stretches that are extreme, bool (t,), and long enough."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], extreme, [0]])))
    pairs = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return [(start, stop) for start, stop in pairs if stop - start >= FEWEST]
