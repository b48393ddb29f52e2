r"""Spread of torque: how far the torque of the true arm may differ from that of the nominal model.

With parameters :math:`\varphi = \varphi_0 + L \xi`, :math:`\xi` standard normal, the torque of joint j at
time t deviates by :math:`y_j(t) L \xi`, whose standard deviation is the length of :math:`y_j(t) L`. The
required statement covers all joints and times together: the band of `factor` standard deviations about the
nominal torque contains the entire torque of a given share of the arms. The factor is the quantile, over
sampled arms, of the largest standardized deviation over a motion. It lies between the quantile for one sample
and that for as many independent samples as there are unknowns.
"""

from dataclasses import dataclass, replace

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.model import Model

DRAWS = 1000
"""Number of sampled arms: the standard error of a share of 5 % is 0.7 %."""
CHUNK = 500
"""Number of samples whose torque is in memory at once for all sampled arms: tens of megabytes."""

TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class TorqueSpread:
    """Uncertainty of an arm's parameters, and the torque band for which limits must leave room."""

    # Square root L of the covariance of the model's parameters, shape (p, r); zero rows for parameters that
    # count as exact.
    root: np.ndarray
    residual: np.ndarray  # standard deviation of torque that no parameter explains, shape (n,) [N m]
    share: float  # share of the arms whose torque the band contains at all times [-]
    factor: float = np.nan  # half the width of the band in standard deviations [-]
    widest: float = np.nan  # factor with which the band contains the entire torque of that share

    def band(self, columns: np.ndarray) -> np.ndarray:
        """Half the width of the band for a regressor of shape (t, n, p), shape (t, n) [N m]."""
        by_unknown = columns @ self.root
        variance = np.einsum("tjr,tjr->tj", by_unknown, by_unknown) + self.residual**2
        return self.factor * np.sqrt(variance)

    def weights(self, columns: np.ndarray, joints: np.ndarray) -> np.ndarray:
        """Derivative of the band by the regressor, for one joint per sample, joints (t,); shape (t, n, p)."""
        rows = np.arange(len(joints))
        by_unknown = columns[rows, joints] @ self.root
        # If the standard deviation is zero, the columns are zero, and so are the weights.
        std = np.maximum(np.sqrt(np.sum(by_unknown**2, axis=1) + self.residual[joints] ** 2), TINY)
        weights = np.zeros_like(columns)
        weights[rows, joints] = self.factor * (by_unknown @ self.root.T) / std[:, None]
        return weights

    def for_motions(self, columns: np.ndarray) -> "TorqueSpread":
        """This spread with the factor for motions like the one with a regressor of shape (t, n, p)."""
        by_unknown = (columns @ self.root).reshape(-1, self.root.shape[1])
        by_unknown = by_unknown[np.any(by_unknown != 0.0, axis=1)]
        if not len(by_unknown):
            return replace(self, factor=0.0, widest=0.0)
        unit = by_unknown / np.linalg.norm(by_unknown, axis=1)[:, None]
        largest = np.max(np.abs(unit @ self._drawn(seed=0)), axis=0)
        factor = float(np.quantile(largest, self.share))
        return replace(self, factor=factor, widest=factor)

    def peaks(self, model: Model, motion: Motion, nominal: np.ndarray) -> np.ndarray:
        """Largest absolute torque of each of `DRAWS` sampled arms and each joint, shape (`DRAWS`, n) [N m].

        The nominal model has these parameters; in a densely sampled motion its torque is `nominal`, (t, n).
        """
        drawn, peaks = self._drawn(seed=1), np.zeros((nominal.shape[1], DRAWS))
        for start in range(0, len(motion), CHUNK):
            rows = slice(start, start + CHUNK)
            columns = model.regressor(model.loaded(motion[rows]))
            torque = nominal[rows][:, :, None] + columns @ self.root @ drawn
            peaks = np.maximum(peaks, np.max(np.abs(torque), axis=0))
        return peaks.T

    def share_beyond(self, peaks: np.ndarray, limit: np.ndarray) -> float:
        """Share of arms whose peaks (k, n), plus unexplained torque, exceed a limit (n,) [N m]."""
        return float(np.mean(np.any(peaks + self.factor * self.residual > limit, axis=1)))

    def _drawn(self, seed: int) -> np.ndarray:
        return np.random.default_rng(seed).normal(size=(self.root.shape[1], DRAWS))


def spread_of(
    covariance: np.ndarray, share: float, residual: np.ndarray, columns: np.ndarray
) -> TorqueSpread | None:
    """The spread for a covariance of the parameters, shape (p, p); None if no parameter is uncertain.

    Parameters with infinite variance count as exact, since no torque limit could leave room for them. `share`
    and `residual` are those of `TorqueSpread`, and `columns` the regressor of a motion like the planned ones,
    shape (t, n, p).
    """
    known = np.isfinite(np.diag(covariance)) & (np.diag(covariance) > 0.0)
    if not np.any(known):
        return None
    std = np.sqrt(np.diag(covariance)[known])
    values, vectors = np.linalg.eigh(covariance[np.ix_(known, known)] / np.outer(std, std))
    root = np.zeros((len(covariance), len(std)))
    root[known] = std[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    return TorqueSpread(root, residual, share).for_motions(columns)
