"""Amplitude: how much of a predicted effect left-out blocks have, where its formula is wrong by a share."""

from typing import NamedTuple

import numpy as np
from scipy import special

SHARES = 40
"""Variances of the formula's error that are weighed against each other, from none to all there is."""


class Amplitude(NamedTuple):
    """One is all of the effect.

    Attributes:
        mean: Amplitude.
        t: Over its standard deviation.
        effective: Number of blocks that show it.
        log_odds: Logarithm of the odds that it is above zero.
    """

    mean: float
    t: float
    effective: float
    log_odds: float


NOTHING = Amplitude(0.0, 0.0, 1.0, 0.0)


class _Shares(NamedTuple):
    """What each block has of an effect, by each share of the formula's error in the scatter.

    Attributes:
        own: Amplitude of each block, shape (k,).
        weight: Of each block, shape (s, k).
        mean: Shape (s,).
        left: Sum of squares about the mean, weighted, shape (s,).
    """

    own: np.ndarray
    weight: np.ndarray
    mean: np.ndarray
    left: np.ndarray

    @classmethod
    def of(cls, along: np.ndarray, size: np.ndarray) -> "_Shares | None":
        """None where fewer than two blocks see it."""
        sees = size > 1e-9 * np.max(size, initial=0.0)
        if np.count_nonzero(sees) < 2:
            return None
        own, noise = along[sees] / size[sees], 1.0 / size[sees]
        ratio = np.append(0.0, np.geomspace(0.01 * noise.min(), 10.0 * noise.max(), SHARES))
        weight = 1.0 / (noise + ratio[:, None])
        mean = weight @ own / weight.sum(axis=1)
        left = np.sum(weight * (own - mean[:, None]) ** 2, axis=1) + np.finfo(float).tiny
        return cls(own, weight, mean, left)

    @property
    def total(self) -> np.ndarray:
        """Of the weights, shape (s,)."""
        return np.asarray(self.weight.sum(axis=1))

    def log_probability(self, mean: float) -> float:
        """Of all blocks where the common amplitude is given, but for a constant."""
        left = self.left + self.total * (self.mean - mean) ** 2
        each = 0.5 * (np.log(self.weight).sum(axis=1) - len(self.own) * np.log(left))
        return float(special.logsumexp(each))


def all_or_nothing(along: np.ndarray, size: np.ndarray) -> float:
    """Logarithm of how much more probable blocks are if they have all of an effect than if they have nothing.

    Args:
        along: As of `amplitude`.
        size: As of `amplitude`.
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
    weight, mean, left, total = shares.weight, shares.mean, shares.left, shares.total
    # Weighted means of known relative weights are distributed so, whatever the weights.
    freedom = len(shares.own) - 1.0
    likelihood = 0.5 * (np.log(weight).sum(axis=1) - np.log(total) - freedom * np.log(left))
    share = np.exp(likelihood - special.logsumexp(likelihood))
    t = mean / np.sqrt(left / freedom / total)
    effective = total**2 / np.sum(weight**2, axis=1)
    above, below = (special.logsumexp(_log_tail(x, freedom), b=share) for x in (t, -t))
    best = int(np.argmax(share))
    return Amplitude(float(mean[best]), float(t[best]), float(share @ effective), float(above - below))


def _log_tail(t: np.ndarray, freedom: float) -> np.ndarray:
    """Logarithm of the probability that Student's t is below some, shape of t."""
    return np.log(np.maximum(special.stdtr(freedom, t), np.finfo(float).tiny))
