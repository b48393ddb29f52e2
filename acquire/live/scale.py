"""Marks on an axis without limits: Rerun numbers an axis at powers of ten; at zero alone if none is near."""

from collections import deque

import numpy as np

MOST = 8
"""Steps of a power of ten between lowest and highest value: as many numbers have room beside a plot."""


class Scale:
    """The power of ten at which an axis of some past is marked, on both sides of zero.

    Args:
        past: That is shown [s].
    """

    def __init__(self, past: float) -> None:
        self._past = past
        self._ranges: deque[tuple[float, float, float]] = deque()

    def add(self, time: np.ndarray, values: np.ndarray) -> float:
        """The mark once these are shown too; NaN while nothing but NaN is.

        Args:
            time: In order, shape (t,) [s].
            values: Shape (t, n).
        """
        known = values[np.isfinite(values)]
        if len(known):
            self._ranges.append((float(time[-1]), float(known.min()), float(known.max())))
        while self._ranges and self._ranges[0][0] < time[-1] - self._past:
            self._ranges.popleft()
        _, lowest, highest = np.array(self._ranges).reshape(-1, 3).T
        span = np.ptp([*lowest, *highest, 0.0])
        return float(10.0 ** np.ceil(np.log10(span / MOST))) if span > 0.0 else float("nan")
