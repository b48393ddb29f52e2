"""Efforts that stay at one value while their joint moves: no drive reports them, or far too coarsely."""

import numpy as np

from ..schema import LARGEST

UNREAD = 0.5
"""Share of samples in motion at one value from which on the value is the median, whatever the joint does."""
UNMEASURED = "efforts at one value in most samples in which their joint moves, as if they were not measured"
WINDOW = 0.1
"""Time over which a joint's motion is looked at [s]; over less, the steps of an encoder look like rest."""
FEWEST = 50
"""Samples in motion, at least: of a few, most may well be alike."""
SLOW = 0.03
"""Share of a joint's usual speed below which it may as well rest."""


def unread(time: np.ndarray, position: np.ndarray, effort: np.ndarray) -> np.ndarray:
    """Share of the samples in motion at which each effort has its most frequent value, shape (n,).

    Args:
        time: Of the samples, shape (t,) [s].
        position: Shape (t, n).
        effort: In any unit, shape (t, n).

    Returns:
        Zero where a joint does not move, or up to `UNREAD`.
    """
    shares = [_share(time, one, measured) for one, measured in zip(position.T, effort.T, strict=True)]
    return np.where(np.array(shares) > UNREAD, shares, 0.0)


def _share(time: np.ndarray, position: np.ndarray, effort: np.ndarray) -> float:
    known = np.abs(position) < LARGEST
    if known.sum() < FEWEST:
        return 0.0
    later, before = (np.interp(time + x * WINDOW / 2, time[known], position[known]) for x in (1, -1))
    moved = np.abs(later - before)
    there = (moved > SLOW * np.percentile(moved, 90)) & np.isfinite(effort)
    if there.sum() < FEWEST:
        return 0.0
    return float(np.unique(effort[there], return_counts=True)[1].max() / there.sum())
