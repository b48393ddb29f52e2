"""One set of bodies for the efforts of all joints: what a sign or unit of one of them does to the others.

Fitted joint by joint, bodies of any mass explain an effort as well as its opposite. The same bodies act on
all joints: if the effort of one counts the other way, no set of them explains it too.
"""

from dataclasses import dataclass

import numpy as np

from ..proposal.agreement import FOLDS, Sampled, friction_columns, odds_of, pieces

UNEVEN = 0.05
"""Share of an effort (root mean square) that gains off by a twentieth leave: a fit of all joints that leaves
less says nothing more of signs and units."""
STILL = 1e-9
"""Standard deviation of an effort over the largest, up to which it does not change."""
EXPLAINS = 0.3
"""The same, up to which one set of bodies explains all joints: the gains are about as stated."""
RIDGES = tuple(10.0**-power for power in range(5, 12))
"""Variance of the noise over that of a column, as it may be: bodies of all joints are told apart far better
than those of one, by differences of columns of a hundredth, in clean logs of a few millionths. The one that
predicts best is taken, of each hypothesis: right bodies, held back too much, explain less than wrong ones."""


@dataclass(frozen=True)
class Coupled:
    """How well one set of bodies predicts efforts that are each multiplied by a factor.

    Attributes:
        missed: Sum of squares of each joint's effort not predicted is f @ missed[r, j] @ f for each of
            `RIDGES`, shape (r, n, n, n).
        size: Sum of squares of each effort about its mean, shape (n,).
        weights: Pieces of each effort that say something of their own, shape (n,).
    """

    missed: np.ndarray
    size: np.ndarray
    weights: np.ndarray

    @classmethod
    def of(cls, torque: np.ndarray, log: Sampled) -> "Coupled":
        """Of columns (t, n, p) of the torque, and a log whose efforts are torques by the gains stated."""
        t, n = log.effort.shape
        spread = log.effort.std(axis=0)
        # An effort that does not change says nothing.
        scale = np.where(spread > STILL * np.abs(log.effort).max(), 1.0 / np.maximum(spread, 1e-300), 0.0)
        columns = _columns(torque, log) * (log.sliding * scale)[:, :, None]
        efforts = np.zeros((t, n, n))
        efforts[:, range(n), range(n)] = (log.effort - log.effort.mean(axis=0)) * scale * log.sliding
        missed = np.zeros((len(RIDGES), n, n, n))
        normal, right = _products(columns, columns), _products(columns, efforts)
        for rows in np.array_split(np.arange(t), FOLDS):
            rest = normal - _products(columns[rows], columns[rows])
            known = right - _products(columns[rows], efforts[rows])
            # By eigenvalues: columns of bodies that nothing tells apart leave a matrix that is singular.
            sizes, vectors = np.linalg.eigh(rest)
            along, seen = vectors.T @ known, columns[rows] @ vectors
            for place, ridge in enumerate(RIDGES):
                held_back = np.maximum(sizes, 0.0) + ridge * (t - len(rows))
                left = efforts[rows] - seen @ (along / held_back[:, None])
                missed[place] += np.einsum("tja,tjb->jab", left, left)
        return cls(missed, (efforts**2).sum(axis=(0, 2)), pieces(log))

    def odds(self, factor: np.ndarray) -> float:
        """Log-likelihood of efforts each times a factor (n,)."""
        return self._odds(self.left(factor))

    def left(self, factor: np.ndarray) -> np.ndarray:
        """Share of the variance of each effort, times its factor (n,), that is not predicted, shape (n,)."""
        left = np.einsum("a,rjab,b->rj", factor, self.missed, factor)
        shares = np.minimum(left / np.maximum(factor**2 * self.size, 1e-300), 1.0)
        return np.asarray(max(shares, key=self._odds))

    def _odds(self, left: np.ndarray) -> float:
        return odds_of(np.maximum(left, UNEVEN**2), self.weights)


def _columns(torque: np.ndarray, log: Sampled) -> np.ndarray:
    """Columns of the torque, and of each joint's friction and offset, scaled to one, shape (t, n, p)."""
    t, n = log.effort.shape
    own = np.zeros((t, n, 4 * n))
    for j in range(n):
        own[:, j, 4 * j : 4 * j + 3] = friction_columns(log.motion, j)
        own[:, j, 4 * j + 3] = 1.0
    columns = np.concatenate([torque, own], axis=2)
    size = np.sqrt((columns**2).mean(axis=0).max(axis=0))
    return columns[:, :, size > 0] / size[size > 0]


def _products(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.tensordot(a, b, axes=([0, 1], [0, 1]))
