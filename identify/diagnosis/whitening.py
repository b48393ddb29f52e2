"""Whitening: what is left of a coloured residual when each sample is told from those before it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import linalg, signal

from ..noise import autocovariance

ORDER = 8
"""Samples from which the next one is told: at three samples a period of the band, some three periods."""
RIDGE = 1e-3
"""White part that any residual has [share of its variance]: rounding of the current and of the model."""


@dataclass(frozen=True, eq=False)
class Whitening:
    """One autoregressive filter a joint.

    Attributes:
        filters: Coefficients, the first one 1, shape (n, order + 1).
        scale: Standard deviation of what the filter leaves, shape (n,) [N m].
        runs: Rows of each run.
        valid: Whether a row and all those before it that the filter needs can be compared, shape (r, n).
    """

    filters: np.ndarray
    scale: np.ndarray
    runs: tuple[slice, ...]
    valid: np.ndarray

    def apply(self, joint: int, values: np.ndarray) -> np.ndarray:
        """White rows of a joint, shape (v, ...), from rows (r, ...)."""
        parts = [signal.lfilter(self.filters[joint], 1.0, values[rows], axis=0) for rows in self.runs]
        return np.concatenate(parts)[self.valid[:, joint]] / self.scale[joint]

    @classmethod
    def of(
        cls, residual: np.ndarray, weight: np.ndarray, runs: Sequence[slice], order: int = ORDER
    ) -> "Whitening":
        """Filters that make a residual (r, n) white; rows of zero weight (r, n) are left out."""
        pieces = [residual[rows] for rows in runs]
        weights = [weight[rows] for rows in runs]
        covariance = autocovariance(pieces, weights, order)
        filters, scale = [], []
        for joint in range(residual.shape[1]):
            own = covariance[:, joint, joint].copy()
            own[0] = max(own[0] * (1 + RIDGE), np.finfo(float).tiny)
            past = linalg.solve_toeplitz(own[:-1], own[1:])
            filters.append(np.concatenate([[1.0], -past]))
            scale.append(np.sqrt(max(own[0] - past @ own[1:], RIDGE * own[0])))
        return cls(np.array(filters), np.array(scale), tuple(runs), _valid(weight, runs, order))

    def elsewhere(self, weight: np.ndarray, runs: Sequence[slice]) -> "Whitening":
        """The same filters for other rows."""
        order = self.filters.shape[1] - 1
        return Whitening(self.filters, self.scale, tuple(runs), _valid(weight, runs, order))


def _valid(weight: np.ndarray, runs: Sequence[slice], order: int) -> np.ndarray:
    valid: np.ndarray = np.zeros(weight.shape, bool)
    for rows in runs:
        whole = np.cumsum(np.pad(weight[rows] > 0, ((1, 0), (0, 0))), axis=0)
        enough: np.ndarray = whole[order + 1 :] - whole[: -order - 1] == order + 1
        valid[rows][order:] = enough
    return valid
