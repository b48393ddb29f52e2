"""Probability of the errors of predicted blocks when the noise is unknown.

The residual of a model is autocorrelated, and its size varies from block to block. So a block counts for as
many independent rows as the autocorrelation leaves it, and its error follows Student's t distribution: blocks
share one variance, from which each deviates by a separate factor.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy import fft, special

FREEDOM = 4.0
"""Degrees of freedom of a block's variance about the common one: mostly within a factor of three."""
TURNS = 30
"""Iterations for the common variance, which then has converged to a thousandth."""
UNCORRELATED = 0.05
"""Autocorrelation below which rows count as uncorrelated [-]; longer lags are noise of the estimate."""
LONGEST_LAG = 2.0
"""Largest lag of the autocorrelation [s]."""


def log_probability(errors: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Log probability of each block's squared error, at the likeliest variance of each joint.

    Constants that all models of the same rows share are omitted.

    Args:
        errors: Sums of squared errors, shape (..., k, n) [(N m)^2].
        rows: Number of independent rows in each sum, shape (k, n).
    """
    scale = common_variance(errors, rows)[..., None, :]
    tail = 0.5 * (rows + FREEDOM) * np.log1p(errors / (FREEDOM * scale))
    return -0.5 * rows * np.log(scale) - tail


def common_variance(errors: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Likeliest common variance of blocks, shape (..., n) [(N m)^2]; outliers count for less.

    Args:
        errors: Sums of squared errors, shape (..., k, n) [(N m)^2].
        rows: Number of independent rows in each sum, shape (k, n).
    """
    total = np.maximum(rows.sum(axis=0), 1e-12)
    errors = np.ascontiguousarray(np.moveaxis(errors, -2, 0))  # blocks first: sums over them are fast
    rows = rows.reshape(len(rows), *(1,) * (errors.ndim - 2), -1)
    variance = np.sum(errors, axis=0) / total + 1e-30
    weighted, share = (rows + FREEDOM) * errors / total, np.empty_like(errors)
    for _ in range(TURNS):
        np.divide(errors, variance, out=share)
        share += FREEDOM
        np.divide(weighted, share, out=share)
        variance = np.sum(share, axis=0) + 1e-30
    return np.asarray(variance)


def trust(errors: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Weight of each block in a fit, shape (k, n): 1 for a typical error, less for an outlier."""
    variance = np.sum(errors, axis=0) / np.maximum(rows.sum(axis=0), 1e-12) + 1e-30
    weight = (rows + FREEDOM) / (FREEDOM + errors / variance)
    typical = np.array(
        [np.median(w[r > 0]) if np.any(r > 0) else 1.0 for w, r in zip(weight.T, rows.T, strict=True)]
    )
    return np.where(rows > 0, weight / typical, 1.0)


def trusted(errors: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Weight of blocks, at most 1, from their errors over the variance and their independent rows."""
    return np.minimum((rows + FREEDOM) / (FREEDOM + errors), 1.0)


def independent_share(
    residual: np.ndarray, runs: Sequence[slice], rate: float, effect: np.ndarray | None = None
) -> np.ndarray:
    """Independent rows over all rows of each joint, shape (n,), for a sum of products of effect and residual.

    The variance of that sum is that for white noise times one plus twice the sum of the products of both
    autocorrelations (Bartlett's formula): a slow residual hardly disturbs a fast effect.

    Args:
        residual: Residual, zero where a row does not count, shape (r, n) [N m].
        runs: Rows of each run.
        rate: Rate of the rows [Hz].
        effect: Torque of the effect, shape (r, n) [N m]; where it is zero or not given, an effect as slow as
            the residual.
    """
    of_residual = autocorrelation(residual, runs, rate)
    of_effect = of_residual.copy()
    if effect is not None:
        acting = np.any(effect, axis=0)
        of_effect[:, acting] = autocorrelation(effect[:, acting], runs, rate)
    share = np.ones(residual.shape[1])
    for joint, (first, second) in enumerate(zip(of_residual.T, of_effect.T, strict=True)):
        below = np.flatnonzero(first < UNCORRELATED)
        stop = below[0] if len(below) else len(first)
        share[joint] = 1.0 / max(1.0 + 2.0 * float(first[1:stop] @ second[1:stop]), 1.0)
    return share


def autocorrelation(values: np.ndarray, runs: Sequence[slice], rate: float) -> np.ndarray:
    """Autocorrelation of columns (r, n) within runs, for lags 0, 1, ... rows, shape (l, n)."""
    longest = max(rows.stop - rows.start for rows in runs)
    count = max(min(longest // 4, int(LONGEST_LAG * rate)), 1)
    products = np.zeros((count, values.shape[1]))
    for rows in runs:
        run = values[rows]
        size = fft.next_fast_len(2 * len(run), real=True)  # twice a prime takes several times as long
        power = np.abs(fft.rfft(run, size, axis=0)) ** 2
        lags = fft.irfft(power, size, axis=0)[: min(count, len(run))]
        products[: len(lags)] += lags
    return products / np.maximum(products[0], 1e-300)


def strain(apart: np.ndarray | float, bounded: np.ndarray | bool = False) -> float:
    """Loss in log probability of unknowns that deviate from their priors, summed over the unknowns.

    A prior counts as one row and may be wrong, just as a block may be an outlier. A bound follows the normal
    distribution of its variance.

    Args:
        apart: Deviations from the prior mean, in prior standard deviations.
        bounded: Whether each prior is a bound.
    """
    return float(np.sum(strains(apart, bounded)))


def strains(apart: np.ndarray | float, bounded: np.ndarray | bool = False) -> np.ndarray:
    """Loss in log probability of each unknown, in the shape of `apart`; arguments as for `strain`."""
    strange = 0.5 * (FREEDOM + 1.0) * np.log1p(np.square(apart) / FREEDOM)
    return np.where(bounded, 0.5 * np.square(apart), strange)


SHARES = 40
"""Number of variances of the formula's error that are averaged over, from none to all of the scatter."""


class _Shares(NamedTuple):
    """Mean amplitudes of i effects, for each of s shares of the formula's error in the blocks' scatter."""

    blockwise: np.ndarray  # amplitude of each block, (i, 1, k)
    sees: np.ndarray  # whether a block sees the effect, (i, 1, k)
    weight: np.ndarray  # weight of each block that sees it, (i, s, k)
    total: np.ndarray  # sum of the weights, (i, s)
    mean: np.ndarray  # weighted mean amplitude, (i, s)
    scatter: np.ndarray  # weighted sum of squares about the mean, (i, s)

    @classmethod
    def of(cls, along: np.ndarray, size: np.ndarray) -> "_Shares":
        """Compute them for effects (i, k), each of which at least two blocks see."""
        sees = seen(size)
        noise = 1.0 / np.where(sees, size, 1.0)
        low, high = (
            np.min(noise, axis=1, where=sees, initial=np.inf),
            np.max(noise, axis=1, where=sees, initial=0),
        )
        ratio = np.geomspace(0.01 * low, 10.0 * high, SHARES, axis=1)
        ratio = np.concatenate([np.zeros((len(ratio), 1)), ratio], axis=1)
        weight = np.where(sees[:, None], 1.0 / (noise[:, None] + ratio[:, :, None]), 0.0)
        blockwise = (along * noise)[:, None]
        total = weight.sum(axis=2)
        mean = np.sum(weight * blockwise, axis=2) / total
        scatter = np.sum(weight * (blockwise - mean[:, :, None]) ** 2, axis=2) + np.finfo(float).tiny
        return cls(blockwise, sees[:, None], weight, total, mean, scatter)

    @property
    def blocks(self) -> np.ndarray:
        """Number of blocks that see each effect, shape (i, 1)."""
        return np.asarray(self.sees.sum(axis=2))

    @property
    def log_weight(self) -> np.ndarray:
        """Sum of the logarithms of the weights, shape (i, s)."""
        return np.asarray(np.log(np.where(self.sees, self.weight, 1.0)).sum(axis=2))

    def log_probability(self, mean: float) -> np.ndarray:
        """Log probability of all blocks at a common amplitude, up to a constant, (i,)."""
        scatter = self.scatter + self.total * (self.mean - mean) ** 2
        return log_sum(0.5 * (self.log_weight - self.blocks * np.log(scatter)))


def log_sum(logs: np.ndarray, share: np.ndarray | float = 1.0) -> np.ndarray:
    """Log of the weighted sum, over the last axis, of terms given by their logarithms."""
    most = np.max(logs, axis=-1, keepdims=True)
    return np.asarray(np.log(np.sum(share * np.exp(logs - most), axis=-1)) + most[..., 0])


def seen(size: np.ndarray) -> np.ndarray:
    """Which blocks see an effect, given its squares over noise, shape (..., k)."""
    return np.asarray(size > 1e-9 * np.max(size, axis=-1, initial=0.0, keepdims=True))


def all_or_nothing(along: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Log odds that blocks contain all of an effect rather than none of it; see `above_zero`."""
    return _of_shares(along, size, lambda shares: shares.log_probability(1.0) - shares.log_probability(0.0))


def above_zero(along: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Log odds that the common amplitude of effects is above zero, shape (...,).

    The amplitude in block i is u_i = along_i / size_i. It deviates from the common one by noise, of variance
    s² / size_i, and by the error of the effect's formula, of variance e²: the random-effects model of
    meta-analysis. Both variances are unknown; s² is estimated (restricted likelihood), and e² / s² is
    integrated over. Where noise dominates, a block counts by its `size`; where the error of the formula
    dominates, all blocks that see the effect count equally. If fewer than two blocks see it, odds are even.

    Args:
        along: Residual of each block along the predicted effects, over noise, shape (..., k).
        size: Squares of the predicted effects in each block, over noise, shape (..., k).
    """
    return _of_shares(along, size, _above_zero)


def _of_shares(along: np.ndarray, size: np.ndarray, log_odds: Callable[[_Shares], np.ndarray]) -> np.ndarray:
    """Log odds (...,) of effects (..., k) that at least two blocks see; zero for all others."""
    enough = np.count_nonzero(seen(size), axis=-1) >= 2
    odds = np.zeros(enough.shape)
    if np.any(enough):
        odds[enough] = log_odds(_Shares.of(along[enough], size[enough]))
    return odds


def _above_zero(shares: _Shares) -> np.ndarray:
    # With known relative weights, weighted means follow these distributions whatever the weights.
    freedom = shares.blocks - 1.0
    likelihood = 0.5 * (shares.log_weight - np.log(shares.total) - freedom * np.log(shares.scatter))
    share = np.exp(likelihood - log_sum(likelihood)[:, None])
    t = shares.mean / np.sqrt(shares.scatter / freedom / shares.total)
    above, below = (
        log_sum(np.log(np.maximum(special.stdtr(freedom, x), np.finfo(float).tiny)), share) for x in (t, -t)
    )
    return above - below
