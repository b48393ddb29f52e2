r"""How much of each joint's effort is left if each block of a log is predicted by the others.

The effort of joint :math:`j` is :math:`y_j = X_j \beta + Z_j \alpha_j + n_j`: bodies and stated effects,
common to all joints, and rotor, friction and offset of the joint. Bodies may have any mass. They are fitted
once with parameters that all joints share, and once for each joint by itself: what fits only by itself has a
wrong geometry, order, sign or scale.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..arm.motion import Motion
from ..arm.rigid_regressor import rigid_regressor
from ..model import Model
from .described_bodies import Stated
from .samples import Sampled

FOLDS = 8
"""Number of blocks, each predicted from the others."""
RIDGE = 1e-6
"""Ridge parameter of shared columns relative to their size: only what nothing determines is held back."""
OWN = 1e-3
"""Weight of the shared parameters as a prior of a joint's own ones, relative to their columns [-]: it matters
only in directions that one joint hardly determines."""
ALONE = 1e-2
"""Ridge parameter of a joint's own parameters if its gain is unknown, so that no parameters are shared."""
EXACT = 1e-4
"""Squared share of an effort below which a fit is not weighted further: no log is more exact."""
NOTHING = 1e-12
"""Size of a column, relative to the largest, below which it counts as zero."""


class Fit(NamedTuple):
    """Squared efforts of a log, and what is left of them in blocks that were not fitted."""

    errors: np.ndarray  # squared errors of each block with shared parameters, shape (k, n)
    alone: np.ndarray  # squared errors with parameters of each joint alone, shape (n,); NaN if not computed
    power: np.ndarray  # sum of the squared efforts, shape (n,)
    variance: np.ndarray  # the same about their mean, shape (n,); 0 if an effort is constant
    residual: np.ndarray  # left-out residual at each sample, 0 where a joint may stick, shape (t, n)

    @property
    def together(self) -> np.ndarray:
        """Squared errors with shared parameters, shape (n,)."""
        return np.asarray(self.errors.sum(axis=0))

    def share(self, errors: np.ndarray) -> np.ndarray:
        """Squared errors (n,) as a share of each effort's variance; 1 if the effort is constant."""
        known = self.variance > 0.0
        return np.where(known, np.minimum(errors / np.where(known, self.variance, 1.0), 1.0), 1.0)


@dataclass(frozen=True)
class Columns:
    """Columns of a motion, in the normal equations of each block."""

    regressor: np.ndarray  # effort of each joint per scaled unknown, 0 where it may stick, shape (n, t, p)
    scale: np.ndarray  # size of each unknown's column in its unit, shape (p,)
    sliding: np.ndarray  # whether each joint slides, bool of shape (t, n)

    @classmethod
    def of(cls, model: Model, log: Sampled, more: np.ndarray | None = None) -> "Columns":
        """Columns of bodies, stated effects, `more` shared columns (t, n, m) first, and joints."""
        shared = [] if more is None else [more]
        shared += [
            rigid_regressor(model.robot.kinematics, log.motion),
            Stated.of(model, log.motion).columns,
        ]
        columns = np.concatenate([*shared, _motor_columns(log.motion, model.robot.coupling)], axis=2)
        columns = columns.transpose(1, 0, 2) * log.sliding.T[:, :, None]
        size = np.sqrt((columns**2).mean(axis=(0, 1)))
        scale = np.where(size > NOTHING * size.max(initial=0.0), size, np.inf)
        return cls(columns / scale, scale, log.sliding)

    @cached_property
    def folds(self) -> list[np.ndarray]:
        """Samples of each block."""
        return np.array_split(np.arange(self.regressor.shape[1]), FOLDS)

    @cached_property
    def grams(self) -> np.ndarray:
        """Products of the columns in each block and joint, shape (k, n, p, p)."""
        parts = [self.regressor[:, rows] for rows in self.folds]
        return np.array([part.transpose(0, 2, 1) @ part for part in parts])

    def fit(self, effort: np.ndarray, shared: bool = True, alone: bool = True, passes: int = 2) -> Fit:
        """Fit efforts (t, n); without `shared` parameters each joint is fitted only alone.

        Each joint is weighted by the inverse of its variance; a further pass uses that of its residual.
        """
        values = effort * self.sliding
        count = np.maximum(self.sliding.sum(axis=0), 1)
        power = (values**2).sum(axis=0)
        variance = power - values.sum(axis=0) ** 2 / count
        variance = np.where(variance > 1e-18 * variance.max(initial=0.0), variance, 0.0)
        products = np.array([np.einsum("jtp,tj->jp", self.regressor[:, f], values[f]) for f in self.folds])
        beta, residual, level = np.zeros((FOLDS, products.shape[2])), values, variance
        for _ in range(passes * shared):
            weight = np.divide(1.0, level, out=np.zeros_like(level), where=variance > 0.0)
            beta = self._shared(products, weight)
            residual = values - self._predicted(beta[:, None])
            level = (residual**2).sum(axis=0) + EXACT * variance
        separate = np.full(len(power), np.nan)
        if alone or not shared:
            separate = ((values - self._predicted(self._alone(products, beta, shared))) ** 2).sum(axis=0)
        errors = np.array([(residual[rows] ** 2).sum(axis=0) for rows in self.folds])
        return Fit(errors, separate, power, variance, residual)

    def normal_equations(self, effort: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Matrix (p, p) and right-hand side (p,) of all samples, with weights (n,) of the joints."""
        right = np.einsum("jtp,tj,j->p", self.regressor, effort * self.sliding, weight)
        return np.tensordot(weight, self.grams.sum(axis=0), axes=1), right

    def _shared(self, products: np.ndarray, weight: np.ndarray) -> np.ndarray:
        """Unknowns fitted without each block, shape (k, p)."""
        flat = weight @ self.grams.reshape(*self.grams.shape[:2], -1)
        matrix = flat.reshape(-1, *self.grams.shape[2:])
        right = weight @ products
        matrix, right = matrix.sum(axis=0) - matrix, right.sum(axis=0) - right
        return _solved(matrix, right, RIDGE * np.einsum("kpp->kp", matrix))

    def _alone(self, products: np.ndarray, shared: np.ndarray, known: bool) -> np.ndarray:
        """Unknowns of each joint alone fitted without each block, shape (k, n, p)."""
        matrix, right = self.grams.sum(axis=0) - self.grams, products.sum(axis=0) - products
        size = np.einsum("knpp->knp", matrix)
        prior = (OWN if known else ALONE) * size
        return _solved(matrix, right + prior * shared[:, None], prior)

    def _predicted(self, beta: np.ndarray) -> np.ndarray:
        """Efforts (t, n) of each block by unknowns (k, n, p), or (k, 1, p) for all joints alike."""
        parts = [
            np.einsum("jtp,jp->tj", self.regressor[:, rows], np.broadcast_to(one, self._shape))
            for rows, one in zip(self.folds, beta, strict=True)
        ]
        return np.concatenate(parts)

    @property
    def _shape(self) -> tuple[int, int]:
        return self.regressor.shape[0], self.regressor.shape[2]


def _motor_columns(motion: Motion, coupling: np.ndarray) -> np.ndarray:
    """Torque of rotor, friction and offset of each motor on the joints that turn it, shape (t, n, 4 n)."""
    n = motion.position.shape[1]
    velocity, acceleration = motion.velocity @ coupling.T, motion.acceleration @ coupling.T
    terms = np.stack([acceleration, velocity, np.sign(velocity), np.ones_like(velocity)], axis=2)
    return np.asarray(np.einsum("tkc,kj->tjkc", terms, coupling)).reshape(len(velocity), n, 4 * n)


def _solved(matrix: np.ndarray, right: np.ndarray, ridge: np.ndarray) -> np.ndarray:
    """Solutions (..., p) of normal equations with a ridge (..., p); unknowns without a column are 0."""
    size = np.einsum("...pp->...p", matrix)
    least = NOTHING * size.max(axis=-1, keepdims=True, initial=0.0) + (size <= 0.0)
    identity = np.eye(matrix.shape[-1])
    return np.asarray(
        np.linalg.solve(matrix + (ridge + least)[..., None] * identity, right[..., None])[..., 0]
    )
