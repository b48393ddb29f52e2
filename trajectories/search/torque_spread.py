r"""Spread of torque: how far the torque of the true arm may be from that of the nominal one.

With parameters :math:`\varphi = \varphi_0 + L \xi`, :math:`\xi` standard normal, the torque of joint j at
time t deviates by :math:`y_j(t) L \xi`, whose standard deviation is the length of :math:`y_j(t) L`. What has
to hold is a statement on all joints and times together: the band of `factor` standard deviations about the
nominal torque holds the whole torque of a stated share of the arms. The factor is the quantile, over drawn
arms, of the largest standardised deviation over a motion. It is between that of one sample and that of as
many independent ones as there are unknowns.
"""

from dataclasses import dataclass, replace

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.model import Model

DRAWS = 1000
"""Arms drawn: of five per cent of them the count has a standard deviation of 0.7 per cent."""
CHUNK = 500
"""Samples whose torque is held at once for all drawn arms: tens of megabytes."""

TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class TorqueSpread:
    """What is not known of an arm's parameters, and how much of it a torque limit must leave room for.

    Attributes:
        root: Square root L of the covariance of the model's parameters, shape (p, r); zero rows for those
            that count as exact.
        residual: Standard deviation of torque that no parameter explains, shape (n,) [N m].
        share: Of the arms, whose torque the band holds at all times [-].
        factor: Standard deviations to either side of the nominal torque [-].
        widest: The factor with which the band holds the whole torque of that share.
    """

    root: np.ndarray
    residual: np.ndarray
    share: float
    factor: float = np.nan
    widest: float = np.nan

    def band(self, columns: np.ndarray) -> np.ndarray:
        """Half the width of the band where these are the columns (t, n, p), shape (t, n) [N m]."""
        return self.factor * self._deviation(columns)

    def weights(self, columns: np.ndarray, joints: np.ndarray) -> np.ndarray:
        """Derivative by the columns (t, n, p) of the band of one joint a sample, joints (t,); (t, n, p)."""
        every = np.arange(len(joints))
        own = columns[every, joints] @ self.root
        # Where the deviation is zero the columns are zero, and so is what they pull.
        deviation = np.maximum(np.sqrt(np.sum(own**2, axis=1) + self.residual[joints] ** 2), TINY)
        found = np.zeros_like(columns)
        found[every, joints] = self.factor * (own @ self.root.T) / deviation[:, None]
        return found

    def _deviation(self, columns: np.ndarray) -> np.ndarray:
        by_unknown = columns @ self.root
        return np.sqrt(np.einsum("tjr,tjr->tj", by_unknown, by_unknown) + self.residual**2)

    def for_motions(self, columns: np.ndarray, seed: int = 0) -> "TorqueSpread":
        """The same with the factor that motions like one need whose columns are (t, n, p)."""
        by_unknown = (columns @ self.root).reshape(-1, self.root.shape[1])
        by_unknown = by_unknown[np.any(by_unknown != 0.0, axis=1)]
        if not len(by_unknown):
            return replace(self, factor=0.0, widest=0.0)
        unit = by_unknown / np.linalg.norm(by_unknown, axis=1)[:, None]
        largest = np.max(np.abs(unit @ self._drawn(seed)), axis=0)
        factor = float(np.quantile(largest, self.share))
        return replace(self, factor=factor, widest=factor)

    def peaks(self, model: Model, motion: Motion, nominal: np.ndarray, seed: int = 1) -> np.ndarray:
        """Largest torque of each of `DRAWS` drawn arms and joint, without its sign, shape (`DRAWS`, n) [N m].

        Args:
            model: The nominal one, whose parameters these are.
            motion: As it is run, at samples near enough to each other.
            nominal: Its torque, shape (t, n) [N m].
            seed: Of the draws.
        """
        drawn, found = self._drawn(seed), np.zeros((nominal.shape[1], DRAWS))
        for start in range(0, len(motion), CHUNK):
            rows = slice(start, start + CHUNK)
            columns = model.regressor(model.loaded(motion[rows]))
            torque = nominal[rows][:, :, None] + columns @ self.root @ drawn
            found = np.maximum(found, np.max(np.abs(torque), axis=0))
        return found.T

    def share_beyond(self, peaks: np.ndarray, limit: np.ndarray) -> float:
        """Share of arms with a peak (k, n), and what no parameter explains, beyond a limit (n,) [N m]."""
        return float(np.mean(np.any(peaks + self.factor * self.residual > limit, axis=1)))

    def _drawn(self, seed: int) -> np.ndarray:
        return np.random.default_rng(seed).normal(size=(self.root.shape[1], DRAWS))


def spread_of(
    covariance: np.ndarray, share: float, residual: np.ndarray, columns: np.ndarray
) -> TorqueSpread | None:
    """The spread for parameters of a covariance (p, p); None where nothing is unsure.

    Args:
        covariance: Infinite variances stand for what is not known at all, which no torque limit could leave
            room for: it counts as exact.
        share: Of arms whose torque the band holds.
        residual: Torque that no parameter explains, shape (n,) [N m].
        columns: Of a motion like those that are planned, shape (t, n, p).
    """
    known = np.isfinite(np.diag(covariance)) & (np.diag(covariance) > 0.0)
    if not np.any(known):
        return None
    std = np.sqrt(np.diag(covariance)[known])
    values, vectors = np.linalg.eigh(covariance[np.ix_(known, known)] / np.outer(std, std))
    root = np.zeros((len(covariance), len(std)))
    root[known] = std[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    return TorqueSpread(root, residual, share).for_motions(columns)
