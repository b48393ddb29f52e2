"""Windows: short simulations from recorded states, and their errors, to which numbers are fitted."""

from collections.abc import Sequence

import numpy as np

from .replay import Run

SECONDS = 1.0
"""Duration of a simulation [s]: long enough for friction to show, short enough for errors to stay small."""
STARTS = 16
"""Number of simulations of all runs."""
STILL = 10.0
"""Motion over the noise of the encoder, below which a joint stands still."""
STRIDE = 10
"""Spacing of the compared samples."""

DIVERGED = 10.0
"""Largest error that counts, relative to the motion of a joint."""

Window = tuple[Run, int, int]
"""A run, and the first and last sample of a simulation."""


def windows(runs: Sequence[Run]) -> list[Window]:
    """Windows of `SECONDS`, evenly spaced over all runs."""
    total = sum(float(run.time[-1] - run.time[0]) for run in runs)
    spacing, chosen = max(total / STARTS, SECONDS), []
    for run in runs:
        for moment in np.arange(run.time[0], run.time[-1] - SECONDS, spacing):
            first, last = np.searchsorted(run.time, [moment, moment + SECONDS])
            chosen.append((run, int(first), int(last)))
    return chosen


def errors(simulations: Sequence[Window], positions: Sequence[np.ndarray]) -> np.ndarray:
    """Simulated minus recorded positions over the motion of the joints, shape (r,).

    Args:
        simulations: Windows.
        positions: Simulated positions after the first sample of each window, (k, n) [rad].
    """
    parts = []
    for (run, first, last), simulated in zip(simulations, positions, strict=True):
        rows = np.arange(first + 1, last + 1)[STRIDE - 1 :: STRIDE]
        moved = np.maximum(np.std(run.position, axis=0), STILL * run.noise + np.finfo(float).tiny)
        parts.append((simulated[STRIDE - 1 :: STRIDE] - run.position[rows]) / moved)
    return np.concatenate(parts).ravel()


def clipped_errors(simulations: Sequence[Window], positions: Sequence[np.ndarray]) -> np.ndarray:
    """Errors as of `errors`, limited to `DIVERGED` where a simulation diverges."""
    residual = errors(simulations, positions)
    return np.clip(np.nan_to_num(residual, posinf=DIVERGED, neginf=-DIVERGED), -DIVERGED, DIVERGED)
