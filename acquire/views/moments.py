"""Moments: the spans of a run in which a torque shows most."""

from typing import NamedTuple

import numpy as np

WINDOW = 0.5
"""Time over which a torque is taken together [s]: about what an eye takes in of a moving arm."""
LEVEL = 0.5
"""Square of a torque in its moments, at least, over the mean square weighted by itself: half of that at which
most of the torque is spent, so that neither a spike nor a long quiet rest counts much."""
MOST = 12
"""Moments of a run; who looks at more sees the run."""


class Moment(NamedTuple):
    """A span of time.

    Attributes:
        begin: [s].
        end: [s].
        over_noise: Root mean square of the torque within, over the noise floor [-].
    """

    begin: float
    end: float
    over_noise: float


def lasting(time: np.ndarray, over_noise: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Root mean square within a window around each row, shape (r, n); NaN where nothing counts.

    Args:
        time: Shape (r,) [s].
        over_noise: Torque over its noise floor, shape (r, n) [-].
        weight: 0 where a joint sticks, else 1, shape (r, n).
    """
    sums, counts = (_near(time, values) for values in (weight * over_noise**2, weight))
    some = counts > 1e-9  # of what rounding leaves of nothing
    return np.where(some, np.sqrt(np.maximum(sums, 0.0) / np.where(some, counts, 1.0)), np.nan)


def _near(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Mean of each column within a window around each row, shape (r, n)."""
    width = max(round(WINDOW / float(np.median(np.diff(time)))), 1) if len(time) > 1 else 1
    window = np.ones(min(width, len(time))) / width
    return np.stack([np.convolve(column, window, mode="same") for column in values.T], axis=1)


def moments(time: np.ndarray, over_noise: np.ndarray) -> list[Moment]:
    """The strongest moments, in order of time.

    Args:
        time: Shape (r,) [s].
        over_noise: Torque over its noise floor, zero where it does not count, shape (r,) [-].
    """
    power = over_noise**2
    if len(time) < 2 or not np.any(power > 0.0):
        return []
    near = _near(time, power[:, None])[:, 0]
    level = LEVEL * float(np.sum(near**2) / np.sum(near))
    spans = [
        Moment(float(time[a]), float(time[b]), float(np.sqrt(np.mean(power[a : b + 1]))))
        for a, b in _spans(time, near >= level)
    ]
    energetic = sorted(spans, key=lambda one: -((one.end - one.begin + WINDOW) * one.over_noise**2))
    return sorted(energetic[:MOST])


def _spans(time: np.ndarray, chosen: np.ndarray) -> list[tuple[int, int]]:
    """First and last row of every stretch; those that a window bridges are one."""
    rows = np.flatnonzero(chosen)
    breaks = np.flatnonzero(np.diff(time[rows]) > WINDOW)
    firsts, lasts = np.concatenate([[0], breaks + 1]), np.concatenate([breaks, [len(rows) - 1]])
    return [(int(rows[first]), int(rows[last])) for first, last in zip(firsts, lasts, strict=True)]
