"""Whitening: what is left of a coloured residual when each sample is told from those before it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg, signal

ORDER = 8
"""Samples from which the next one is told: at three samples a period of the band, some three periods."""
RIDGE = 1e-3
"""White part that any residual has [share of its variance]: rounding of the current and of the model."""
MEMORY = 512
"""Samples after which a residual has forgotten: longer than any gap across which something is told."""
FADING = 0.98
"""By how much a filter that never forgets is shortened a sample, until it does [-]."""


@dataclass(frozen=True, eq=False)
class Gaps:
    """Rows of one joint that count and whose past has gaps: after a rest, or at the start of a run.

    Attributes:
        rows: Which, shape (g,).
        past: The rows that count before each, the last first, shape (g, order); -1 where there are none.
    """

    rows: np.ndarray
    past: np.ndarray

    @classmethod
    def of(cls, counts: np.ndarray, runs: Sequence[slice], order: int) -> "Gaps":
        """Where rows (r,) that count have one that does not among those before them."""
        rows, past = [np.zeros(0, int)], [np.zeros((0, order), int)]
        for run in runs:
            own = run.start + np.flatnonzero(counts[run])
            before = np.pad(own, (order, 0), constant_values=-1)
            last = before[np.arange(len(own))[:, None] + np.arange(order)[::-1]]
            torn = np.any((own[:, None] - last != np.arange(1, order + 1)) | (last < 0), axis=1)
            rows.append(own[torn])
            past.append(last[torn])
        return cls(np.concatenate(rows), np.concatenate(past))

    def bridges(self, filter_: np.ndarray, scale: float) -> tuple[np.ndarray, np.ndarray]:
        """Filters across the gaps (g, order + 1) and what they leave (g,), for the filter without gaps."""
        covariance = autocovariance(filter_, scale)
        there = self.past >= 0
        lags = np.where(there, self.rows[:, None] - self.past, 0)
        cross = np.where(there, covariance[np.minimum(lags, MEMORY)], 0.0)
        both = there[:, :, None] & there[:, None, :]
        apart = np.minimum(np.abs(lags[:, :, None] - lags[:, None, :]), MEMORY)
        own = np.where(both, covariance[apart], np.eye(lags.shape[1]) * covariance[0])
        past = np.linalg.solve(own, cross[:, :, None])[:, :, 0]
        variance = covariance[0] - np.sum(past * cross, axis=1)
        taps = np.concatenate([np.ones((len(past), 1)), -past], axis=1)
        return taps, np.sqrt(np.maximum(variance, scale**2))


@dataclass(frozen=True, eq=False)
class Whitening:
    """One autoregressive filter a joint.

    Attributes:
        filters: Coefficients, the first one 1, shape (n, order + 1).
        scale: Standard deviation of what the filter leaves, shape (n,) [N m].
        runs: Rows of each run.
        valid: Whether a row counts, shape (r, n).
        gaps: Of each joint.
        bridges: Filters across these gaps (g, order + 1), and what they leave (g,) [N m], of each joint.
    """

    filters: np.ndarray
    scale: np.ndarray
    runs: tuple[slice, ...]
    valid: np.ndarray
    gaps: tuple[Gaps, ...]
    bridges: tuple[tuple[np.ndarray, np.ndarray], ...]

    def apply(self, joint: int, values: np.ndarray) -> np.ndarray:
        """White rows of a joint, shape (v, ...), from rows (r, ...)."""
        taps = self.filters[joint] / self.scale[joint]
        white = taps[0] * values
        for lag, tap in enumerate(taps[1:], 1):
            white[lag:] += tap * values[:-lag]
        gaps, (bridges, scale) = self.gaps[joint], self.bridges[joint]
        across = np.einsum("gk,gk...->g...", bridges[:, 1:], values[gaps.past])
        white[gaps.rows] = ((values[gaps.rows] + across).T / scale).T
        return white[self.valid[:, joint]]

    def logarithm(self, joint: int) -> float:
        """Sum of the logarithms of the standard deviations of a joint's white rows [N m]."""
        torn = np.log(self.bridges[joint][1])
        whole = np.sum(self.valid[:, joint]) - len(torn)
        return float(whole * np.log(self.scale[joint]) + np.sum(torn))

    @classmethod
    def of(
        cls, residual: np.ndarray, weight: np.ndarray, runs: Sequence[slice], order: int = ORDER
    ) -> "Whitening":
        """Filters that make a residual (r, n) white; rows of zero weight (r, n) are left out."""
        dof = residual.shape[1]
        whitening = cls._with(np.eye(1, order + 1).repeat(dof, 0), np.ones(dof), weight, runs)
        for joint in range(dof):
            whitening = whitening.recoloured(joint, residual[:, joint])
        return whitening

    def recoloured(self, joint: int, residual: np.ndarray) -> "Whitening":
        """With the filter of one joint that makes another residual (r,) white."""
        order = self.filters.shape[1] - 1
        whole = self.valid[:, joint].copy()
        whole[self.gaps[joint].rows] = False
        if not np.any(self.valid[:, joint]):
            return self
        pasts = residual[np.flatnonzero(whole)[:, None] - np.arange(order + 1)]
        if len(pasts) < 2 * order:
            size = (
                np.linalg.norm(residual[self.valid[:, joint]]) / max(np.sum(self.valid[:, joint]), 1) ** 0.5
            )
            pasts = np.concatenate([pasts, size * np.eye(order + 1)])
        filters, scale, bridges = self.filters.copy(), self.scale.copy(), list(self.bridges)
        filters[joint], scale[joint] = _forecast(pasts)
        bridges[joint] = self.gaps[joint].bridges(filters[joint], float(scale[joint]))
        return replace(self, filters=filters, scale=scale, bridges=tuple(bridges))

    def elsewhere(self, weight: np.ndarray, runs: Sequence[slice]) -> "Whitening":
        """The same filters for other rows."""
        return self._with(self.filters, self.scale, weight, runs)

    @classmethod
    def _with(
        cls, filters: np.ndarray, scale: np.ndarray, weight: np.ndarray, runs: Sequence[slice]
    ) -> "Whitening":
        gaps = tuple(Gaps.of(own, runs, filters.shape[1] - 1) for own in weight.T > 0)
        bridges = tuple(gap.bridges(f, float(s)) for gap, f, s in zip(gaps, filters, scale, strict=True))
        return cls(filters, scale, tuple(runs), weight > 0, gaps, bridges)


def autocovariance(filter_: np.ndarray, scale: float) -> np.ndarray:
    """Of what a filter (order + 1,) makes white, at lags 0 to MEMORY, the last of which is zero."""
    impulse = np.eye(1, 2 * MEMORY)[0]
    while True:
        response = signal.lfilter([1.0], filter_, impulse)
        if np.all(np.isfinite(response)) and abs(response[-1]) < 1e-3 * np.max(np.abs(response)):
            break
        filter_ = filter_ * FADING ** np.arange(len(filter_))
    density = np.abs(np.fft.rfft(response, 4 * MEMORY)) ** 2
    covariance = scale**2 * np.fft.irfft(density)[: MEMORY + 1]
    covariance[0] *= 1 + RIDGE
    covariance[MEMORY] = 0.0
    return covariance


def _forecast(pasts: np.ndarray) -> tuple[np.ndarray, float]:
    """Coefficients of the filter that tells samples from their pasts (v, order + 1), and what it leaves."""
    variance = max(float(np.mean(pasts[:, 0] ** 2)), np.finfo(float).tiny)
    gram = pasts[:, 1:].T @ pasts[:, 1:] + RIDGE * variance * len(pasts) * np.eye(pasts.shape[1] - 1)
    filter_ = np.concatenate([[1.0], -linalg.solve(gram, pasts[:, 1:].T @ pasts[:, 0], assume_a="pos")])
    left = float(np.mean((pasts @ filter_) ** 2))
    return filter_, np.sqrt(max(left, RIDGE * variance))
