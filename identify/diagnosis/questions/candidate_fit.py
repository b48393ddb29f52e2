"""Candidate fit: coefficients of candidates by all fitted blocks, within what physics allows."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..blocks.prediction import Prediction, rms_torque
from .block_answer import STRANGE, prior_std
from .candidate import Candidate, Thinned

FORMULA = 0.1
"""Error of a formula of friction or gears, share of its torque [-]: none is right to better than a tenth."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """Coefficients of i candidates, p each, by all fitted blocks, and their priors."""

    values: np.ndarray  # shape (i, p); zero where the effect cannot be
    free: np.ndarray  # which are not at a limit of physics, (i, p); none where the effect cannot be
    precision: np.ndarray  # inverse variance of their priors, shape (i, p)
    mean: np.ndarray  # prior mean, shape (i, p)
    possible: np.ndarray  # whether physics allows the candidate, shape (i,)

    def possible_where(self, possible: np.ndarray) -> "Fitted":
        """The same where candidates are possible (i,)."""
        here = possible[:, None]
        return replace(
            self,
            values=np.where(here, self.values, 0.0),
            free=self.free & here,
            possible=self.possible & possible,
        )

    def held(self, matrix: np.ndarray) -> np.ndarray:
        """Normal matrices (i, p, p) with priors, of free coefficients; those that are held have one."""
        free = self.free[:, :, None] & self.free[:, None, :]
        return np.where(free, with_diagonal(matrix, self.precision), np.eye(self.free.shape[1]))


def fitted(matrix: np.ndarray, right: np.ndarray, alike: Sequence[tuple[Candidate, Thinned]]) -> Fitted:
    """Coefficients of candidates, held at their limits of physics.

    Args:
        matrix: Normal matrices of their coefficients beside the others, shape (i, p, p).
        right: Right-hand sides, shape (i, p).
        alike: Candidates and their columns.
    """
    mean = np.array([columns.mean for _, columns in alike])
    precision = np.array([prior_std(*pair) for pair in alike]) ** -2.0
    lower = np.array([candidate.lower for candidate, _ in alike])
    matrix, right = with_diagonal(matrix, precision), right + precision * mean
    free, values = np.ones(lower.shape, bool), np.zeros(lower.shape)
    for _ in range(lower.shape[1] + 1):
        values = solved(matrix, right, values, free)
        below = free & (values < lower)
        if not np.any(below):
            break
        free &= ~below
        values[below] = lower[below]
    led = np.array([c.led > 0 and not np.any(own[: c.led]) for (c, _), own in zip(alike, free, strict=True)])
    most = np.array([candidate.most for candidate, _ in alike])
    excluded = led | ~np.any(free, axis=1) | np.any(np.abs(values) > most[:, None], axis=1)
    possible = ~excluded & np.all(np.isfinite(values), axis=1)
    everything = Fitted(values, free, precision, mean, np.ones(len(alike), bool))
    return everything.possible_where(possible)


def beside_limits(
    prediction: Prediction, apart: np.ndarray, matrix: np.ndarray, every: Sequence[Thinned], fits: Fitted
) -> Fitted:
    """Coefficients where nothing else would have to be beyond its limit of physics beside them.

    A friction that needs the viscous friction to be negative is not that friction; by a tenth of its own
    torque it may, since no formula is better.

    Args:
        prediction: Without the candidates.
        apart: By how much less the unknowns that physics limits are per unit of each coefficient, (i, p, l).
        matrix: Normal matrices of the coefficients beside the others, shape (i, p, p).
        every: Columns of the candidates.
        fits: The coefficients.
    """
    places = prediction.rows.limited
    if not len(places):
        return fits
    lower, before = prediction.rows.lower[places], prediction.values[places]
    after = before - np.einsum("ipl,ip->il", apart, fits.values)
    moved = np.where(fits.free[:, :, None], apart, 0.0)
    own = np.sum(moved * np.linalg.solve(fits.held(matrix), moved), axis=1)
    std = np.sqrt(prediction.limited_std**2 + np.maximum(own, 0.0))
    below = np.minimum(lower, before) - STRANGE * std - after
    possible = np.ones(len(every), bool)
    for number in np.flatnonzero(fits.possible & np.any(below > 0.0, axis=1)).tolist():
        torque = float(rms_torque((every[number].values @ fits.values[number])[:, :, None])[0])
        may = FORMULA * torque / np.maximum(prediction.limited_size, 1e-300)
        possible[number] = not np.any(below[number] > may)
    return fits.possible_where(possible)


def solved(matrix: np.ndarray, right: np.ndarray, values: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Unknowns of small systems (..., p, p), (..., p): some are free, the others at their values (..., p)."""
    held, every = np.where(free, 0.0, values), np.eye(matrix.shape[-1])
    right = np.where(free, right - (matrix @ held[..., None])[..., 0], 0.0)
    size = np.sqrt(np.maximum(np.diagonal(matrix, axis1=-2, axis2=-1), 1e-300))
    scaled = np.where(
        free[..., :, None] & free[..., None, :],
        matrix / (size[..., :, None] * size[..., None, :]),
        every,
    )
    scaled = scaled + 1e-10 * every
    return np.where(free, np.linalg.solve(scaled, (right / size)[..., None])[..., 0] / size, held)


def with_diagonal(matrix: np.ndarray, more: np.ndarray) -> np.ndarray:
    """Matrices (..., p, p) with more (..., p) on their diagonals."""
    found = matrix.copy()
    diagonal = np.einsum("...pp->...p", found)  # a view
    diagonal += more
    return found
