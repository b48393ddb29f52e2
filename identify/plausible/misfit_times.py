"""Times at which several joints leave the model together, as when something pushes the arm or it is held."""

import numpy as np
from scipy.ndimage import binary_closing, uniform_filter1d

from .evidence import Reading

WINDOW = 0.4
"""Length over which residuals are averaged [s]: shorter than a push, longer than a jerk of dry friction."""
LARGE = 3.0
"""Residual over its median from which on it is not that of the rest of the log [-]; noise and friction stay
below twice the median over such a window."""
MOSTLY = 0.5
"""Least share of the squared residual that lies in these times, if they are the cause of the misfit."""
RARE = 0.3
"""Largest share of the log that they take up: the rest tells what is usual."""


def misfit_times(reading: Reading) -> list[tuple[float, float]]:
    """First and last time [s] of each interval in which two or more joints leave the model at once."""
    time, residual = reading.log.motion.time, reading.fit.residual
    if (
        not reading.stated or len(time) < 2 or np.any(np.diff(time) <= 0.0)
    ):  # several runs have no common time
        return []
    size = max(3, round(WINDOW / float(np.median(np.diff(time)))))
    squared = uniform_filter1d(residual**2, size, axis=0)
    usual = np.maximum(np.median(squared, axis=0), 1e-300)
    ratio = squared / usual
    together = (ratio > LARGE**2).sum(axis=1) >= 2
    relative = (residual**2 / usual).sum(axis=1)
    if together.mean() > RARE or relative[together].sum() < MOSTLY * relative.sum():
        return []
    return [(float(time[rows.start]), float(time[rows.stop - 1])) for rows in _stretches(together, size)]


def _stretches(marked: np.ndarray, size: int) -> list[slice]:
    """Stretches of marked samples, joined over gaps of fewer than `size`, without those of half of that."""
    closed = binary_closing(np.pad(marked, size), np.ones(size))[size:-size] | marked
    edges = np.flatnonzero(np.diff(np.pad(closed.astype(int), 1))).reshape(-1, 2).tolist()
    return [slice(first, last) for first, last in edges if last - first > size // 2]
