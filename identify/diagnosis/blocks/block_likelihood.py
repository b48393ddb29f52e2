"""How probable the errors of predicted blocks are, whatever their noise.

What a model leaves is coloured and of another size in every block. So a block counts for as many independent
rows as the colour of the residual leaves it, and its error follows Student's t: blocks share one variance,
each is off from it by a factor of its own.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import fft, special

FREEDOM = 4.0
"""Degrees of freedom of a block's variance about the common one: it is within a factor of three, mostly."""
TURNS = 30
"""Iterations of the common variance, after which it is right to a thousandth."""
FORGOTTEN = 0.05
"""Autocorrelation at which a residual has forgotten [-]; what follows is noise of the estimate."""
MEMORY = 2.0
"""Time over which autocorrelation is looked at [s]."""


def log_probability(errors: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Logarithm of the probability of each block's squared error, at the likeliest variance of each joint.

    Of sums of squares (..., k, n) [(N m)^2] over so many independent rows (k, n); shape (..., k, n), without
    constants that all models of the same rows have.
    """
    scale = common_variance(errors, rows)[..., None, :]
    tail = 0.5 * (rows + FREEDOM) * np.log1p(errors / (FREEDOM * scale))
    return -0.5 * rows * np.log(scale) - tail


def common_variance(errors: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Likeliest variance that blocks share, shape (..., n) [(N m)^2]; those of strange errors count for less.

    Of sums of squares (..., k, n) [(N m)^2] over so many independent rows (k, n).
    """
    total = np.maximum(rows.sum(axis=0), 1e-12)
    variance = np.sum(errors, axis=-2) / total + 1e-30
    for _ in range(TURNS):
        share = (rows + FREEDOM) / (FREEDOM + errors / variance[..., None, :])
        variance = np.sum(share * errors, axis=-2) / total + 1e-30
    return np.asarray(variance)


def trust(errors: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Weight of each block in a fit, shape (k, n): one of usual error has one, a strange one less."""
    variance = np.sum(errors, axis=0) / np.maximum(rows.sum(axis=0), 1e-12) + 1e-30
    weight = (rows + FREEDOM) / (FREEDOM + errors / variance)
    usual = np.array(
        [np.median(w[r > 0]) if np.any(r > 0) else 1.0 for w, r in zip(weight.T, rows.T, strict=True)]
    )
    return np.where(rows > 0, weight / usual, 1.0)


def trusted(errors: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Weight of blocks of so many independent rows by their errors over the variance, none above one."""
    return np.minimum((rows + FREEDOM) / (FREEDOM + errors), 1.0)


def independent_share(
    residual: np.ndarray, runs: Sequence[slice], rate: float, effect: np.ndarray | None = None
) -> np.ndarray:
    """Independent rows over all rows of each joint, shape (n,), for a sum of products of effect and residual.

    Its variance is that of white noise times one plus twice the sum of the products of both
    autocorrelations (Bartlett's formula): what is fast is seen through what is slow.

    Args:
        residual: Shape (r, n), zero where a row does not count.
        runs: Rows of each run.
        rate: Rows a second [Hz].
        effect: Shape (r, n); as slow as the residual where it is zero everywhere, or not given.
    """
    own = autocorrelation(residual, runs, rate)
    other = own.copy()
    if effect is not None:
        acting = np.any(effect, axis=0)
        other[:, acting] = autocorrelation(effect[:, acting], runs, rate)
    found = np.ones(residual.shape[1])
    for joint, (one, two) in enumerate(zip(own.T, other.T, strict=True)):
        below = np.flatnonzero(one < FORGOTTEN)
        stop = below[0] if len(below) else len(one)
        found[joint] = 1.0 / max(1.0 + 2.0 * float(one[1:stop] @ two[1:stop]), 1.0)
    return found


def autocorrelation(values: np.ndarray, runs: Sequence[slice], rate: float) -> np.ndarray:
    """Autocorrelation of columns (r, n) within runs, for lags from zero on, shape (l, n)."""
    longest = max(rows.stop - rows.start for rows in runs)
    count = max(min(longest // 4, int(MEMORY * rate)), 1)
    products = np.zeros((count, values.shape[1]))
    for rows in runs:
        own = values[rows]
        size = fft.next_fast_len(2 * len(own), real=True)  # twice a prime takes several times as long
        power = np.abs(fft.rfft(own, size, axis=0)) ** 2
        lags = fft.irfft(power, size, axis=0)[: min(count, len(own))]
        products[: len(lags)] += lags
    return products / np.maximum(products[0], 1e-300)


def strain(apart: np.ndarray | float, bounded: np.ndarray | bool = False) -> float:
    """Logarithm of the probability that unknowns lose by being so many standard deviations from their priors.

    A prior is one row, and may be wrong as a block may be strange. A bound is no more likely to be exceeded
    than the normal distribution of its variance states.
    """
    return float(np.sum(strains(apart, bounded)))


def strains(apart: np.ndarray | float, bounded: np.ndarray | bool = False) -> np.ndarray:
    """The same for each unknown, in the shape of `apart`."""
    strange = 0.5 * (FREEDOM + 1.0) * np.log1p(np.square(apart) / FREEDOM)
    return np.where(bounded, 0.5 * np.square(apart), strange)


SHARES = 40
"""Variances of the formula's error that are weighed against each other, from none to all there is."""


class Amplitude(NamedTuple):
    """How much of a predicted effect blocks have: one is all of it."""

    mean: float
    t: float  # mean over its standard deviation
    effective: float  # number of blocks that show it
    log_odds: float  # logarithm of the odds that it is above zero


NOTHING = Amplitude(0.0, 0.0, 1.0, 0.0)


class _Shares(NamedTuple):
    """Amplitudes of the blocks, by each of s shares of the formula's error in their scatter."""

    own: np.ndarray  # amplitude of each block, (k,)
    weight: np.ndarray  # of each block, (s, k)
    total: np.ndarray  # of the weights, (s,)
    mean: np.ndarray  # (s,)
    left: np.ndarray  # weighted sum of squares about the mean, (s,)

    @classmethod
    def of(cls, along: np.ndarray, size: np.ndarray) -> "_Shares | None":
        """None where fewer than two blocks see it."""
        sees = size > 1e-9 * np.max(size, initial=0.0)
        if np.count_nonzero(sees) < 2:
            return None
        own, noise = along[sees] / size[sees], 1.0 / size[sees]
        ratio = np.append(0.0, np.geomspace(0.01 * noise.min(), 10.0 * noise.max(), SHARES))
        weight = 1.0 / (noise + ratio[:, None])
        total = weight.sum(axis=1)
        mean = weight @ own / total
        left = np.sum(weight * (own - mean[:, None]) ** 2, axis=1) + np.finfo(float).tiny
        return cls(own, weight, total, mean, left)

    def log_probability(self, mean: float) -> float:
        """Logarithm of the probability of all blocks at a common amplitude, but for a constant."""
        left = self.left + self.total * (self.mean - mean) ** 2
        each = 0.5 * (np.log(self.weight).sum(axis=1) - len(self.own) * np.log(left))
        return float(special.logsumexp(each))


def all_or_nothing(along: np.ndarray, size: np.ndarray) -> float:
    """Logarithm of the odds that blocks have all of an effect against that they have nothing of it.

    Arguments are those of `amplitude`.
    """
    shares = _Shares.of(along, size)
    return 0.0 if shares is None else shares.log_probability(1.0) - shares.log_probability(0.0)


def amplitude(along: np.ndarray, size: np.ndarray) -> Amplitude:
    """Amplitude of an effect of which each block has its own share.

    The amplitude in block i is u_i = along_i / size_i. It is off from the common one by noise, of variance
    s² / size_i, and by the error of the effect's formula, of variance e²: the random-effects model of
    meta-analysis. Both variances are unknown; s² is estimated (restricted likelihood), e² / s² is integrated
    over. Where noise prevails, a block counts for what it sees; where the formula's error does, all that see
    the effect count alike.

    Args:
        along: Residual of each block along the predicted effect, over noise, shape (k,).
        size: Square of the predicted effect, over noise, shape (k,).
    """
    shares = _Shares.of(along, size)
    if shares is None:
        return NOTHING
    own, weight, total, mean, left = shares
    # Weighted means of known relative weights are distributed so, whatever the weights.
    freedom = len(own) - 1.0
    likelihood = 0.5 * (np.log(weight).sum(axis=1) - np.log(total) - freedom * np.log(left))
    share = np.exp(likelihood - special.logsumexp(likelihood))
    t = mean / np.sqrt(left / freedom / total)
    effective = total**2 / np.sum(weight**2, axis=1)
    tails = (np.log(np.maximum(special.stdtr(freedom, x), np.finfo(float).tiny)) for x in (t, -t))
    above, below = (special.logsumexp(tail, b=share) for tail in tails)
    best = int(np.argmax(share))
    return Amplitude(float(mean[best]), float(t[best]), float(share @ effective), float(above - below))
