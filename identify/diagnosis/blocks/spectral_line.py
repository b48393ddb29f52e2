"""Spectral line: a frequency at which several spectra stand out above noise."""

import math

import numpy as np

AROUND = 161
"""Number of separate frequencies whose median is the level of noise, which is then known to a tenth."""
LINES = 1e-4
"""Probability that noise alone has a spectral line that stands out as much."""
CORRELATED = 1.5
"""Factor on the power of noise that allows for neighbors that a window correlates [-]."""


def spectral_line(powers: np.ndarray, oversampling: int) -> int | None:
    """Index of the line that at least two spectra (m, f) share, or the only one shows; None without a line.

    Args:
        powers: Power spectra on a common grid, shape (m, f).
        oversampling: Grid points for each frequency that the data distinguish.
    """
    count, several = powers.shape[1], min(2, len(powers))
    if count < AROUND * oversampling:  # a slope would be the level's error
        return None
    parts = np.array_split(powers, count // (AROUND * oversampling), axis=1)
    ratios = [part / np.maximum(np.median(part, axis=1, keepdims=True), 1e-300) for part in parts]
    shared = np.log(2.0) * np.sort(np.concatenate(ratios, axis=1), axis=0)[-several]
    best = int(np.argmax(shared))
    # The power of noise is exponential.
    chance = count * math.comb(len(powers), several) * np.exp(-several * shared[best] / CORRELATED)
    return best if chance < LINES else None
