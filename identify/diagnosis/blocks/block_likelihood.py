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
    """Amplitudes of the blocks of i effects, by each of s shares of the formula's error in their scatter."""

    own: np.ndarray  # amplitude of each block, (i, 1, k)
    sees: np.ndarray  # whether a block sees the effect, (i, 1, k)
    weight: np.ndarray  # of each block that does, (i, s, k)
    total: np.ndarray  # of the weights, (i, s)
    mean: np.ndarray  # (i, s)
    left: np.ndarray  # weighted sum of squares about the mean, (i, s)

    @classmethod
    def of(cls, along: np.ndarray, size: np.ndarray) -> "_Shares":
        """Of effects (i, k), each of which at least two blocks see."""
        sees = seen(size)
        noise = 1.0 / np.where(sees, size, 1.0)
        low, high = (
            np.min(noise, axis=1, where=sees, initial=np.inf),
            np.max(noise, axis=1, where=sees, initial=0),
        )
        ratio = np.geomspace(0.01 * low, 10.0 * high, SHARES, axis=1)
        ratio = np.concatenate([np.zeros((len(ratio), 1)), ratio], axis=1)
        weight = np.where(sees[:, None], 1.0 / (noise[:, None] + ratio[:, :, None]), 0.0)
        own = (along * noise)[:, None]
        total = weight.sum(axis=2)
        mean = np.sum(weight * own, axis=2) / total
        left = np.sum(weight * (own - mean[:, :, None]) ** 2, axis=2) + np.finfo(float).tiny
        return cls(own, sees[:, None], weight, total, mean, left)

    @property
    def blocks(self) -> np.ndarray:
        """Number of blocks that see each effect, shape (i, 1)."""
        return np.asarray(self.sees.sum(axis=2))

    @property
    def log_weight(self) -> np.ndarray:
        """Sum of the logarithms of the weights, shape (i, s)."""
        return np.asarray(np.log(np.where(self.sees, self.weight, 1.0)).sum(axis=2))

    def log_probability(self, mean: float) -> np.ndarray:
        """Logarithm of the probability of all blocks at a common amplitude, but for a constant, (i,)."""
        left = self.left + self.total * (self.mean - mean) ** 2
        return log_sum(0.5 * (self.log_weight - self.blocks * np.log(left)))


def log_sum(logs: np.ndarray, share: np.ndarray | float = 1.0) -> np.ndarray:
    """Logarithm of the sum over the last axis of shares of what has these logarithms."""
    most = np.max(logs, axis=-1, keepdims=True)
    return np.asarray(np.log(np.sum(share * np.exp(logs - most), axis=-1)) + most[..., 0])


def seen(size: np.ndarray) -> np.ndarray:
    """Which blocks see an effect, by its squares over noise, shape (..., k)."""
    return np.asarray(size > 1e-9 * np.max(size, axis=-1, initial=0.0, keepdims=True))


def all_or_nothing(along: np.ndarray, size: np.ndarray) -> float:
    """Logarithm of the odds that blocks have all of an effect against that they have nothing of it.

    Arguments are those of `amplitude`.
    """
    return float(all_or_nothing_of_each(along[None], size[None])[0])


def all_or_nothing_of_each(along: np.ndarray, size: np.ndarray) -> np.ndarray:
    """The same of several effects, each argument of shape (i, k): shape (i,)."""
    found, enough = np.zeros(len(along)), np.count_nonzero(seen(size), axis=1) >= 2
    if np.any(enough):
        shares = _Shares.of(along[enough], size[enough])
        found[enough] = shares.log_probability(1.0) - shares.log_probability(0.0)
    return found


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
    return amplitudes(along[None], size[None])[0]


def amplitudes(along: np.ndarray, size: np.ndarray) -> list[Amplitude]:
    """Those of several effects, each argument of shape (i, k)."""
    found, enough = [NOTHING] * len(along), np.flatnonzero(np.count_nonzero(seen(size), axis=1) >= 2)
    if not len(enough):
        return found
    shares = _Shares.of(along[enough], size[enough])
    # Weighted means of known relative weights are distributed so, whatever the weights.
    freedom = shares.blocks - 1.0
    likelihood = 0.5 * (shares.log_weight - np.log(shares.total) - freedom * np.log(shares.left))
    share = np.exp(likelihood - log_sum(likelihood)[:, None])
    t = shares.mean / np.sqrt(shares.left / freedom / shares.total)
    effective = np.sum(share * shares.total**2 / np.sum(shares.weight**2, axis=2), axis=1)
    above, below = (
        log_sum(np.log(np.maximum(special.stdtr(freedom, x), np.finfo(float).tiny)), share) for x in (t, -t)
    )
    best = np.argmax(share, axis=1)
    for place, (number, first) in enumerate(zip(enough, best, strict=True)):
        odds = float(above[place] - below[place])
        mean, steps = float(shares.mean[place, first]), float(t[place, first])
        found[number] = Amplitude(mean, steps, float(effective[place]), odds)
    return found
