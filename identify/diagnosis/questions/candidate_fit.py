"""Candidate fit: coefficients of one candidate by all fitted blocks, within what physics allows."""

from typing import NamedTuple

import numpy as np

from ..blocks.prediction import Prediction, rms_torque
from .block_answer import STRANGE, prior_std
from .candidate import Candidate, Thinned

FORMULA = 0.1
"""Error of a formula of friction or gears, share of its torque [-]: none is right to better than a tenth."""


class Fitted(NamedTuple):
    """Coefficients of one candidate by all fitted blocks (p,), which of them are free, and their priors."""

    values: np.ndarray
    free: np.ndarray
    precision: np.ndarray
    mean: np.ndarray


def fitted(matrix: np.ndarray, right: np.ndarray, candidate: Candidate, columns: Thinned) -> Fitted | None:
    """Coefficients of one candidate; None where the effect cannot be.

    Those that physics does not let below a limit stay there.
    """
    precision, lower = prior_std(candidate, columns) ** -2.0, np.array(candidate.lower)
    matrix, right = matrix + np.diag(precision), right + precision * columns.mean
    free, values = np.ones(len(lower), bool), np.zeros(len(lower))
    while np.any(free):
        values = solved(matrix, right, values, free)
        below = free & (values < lower)
        if not np.any(below):
            break
        free &= ~below
        values[below] = lower[below]
    led = candidate.led > 0 and not np.any(free[: candidate.led])
    too_large = np.any(np.abs(values) > candidate.most)
    if led or not np.any(free) or too_large or not np.all(np.isfinite(values)):
        return None
    return Fitted(values, free, precision, columns.mean)


def beside_limits(
    prediction: Prediction, apart: np.ndarray, matrix: np.ndarray, columns: Thinned, one: Fitted | None
) -> Fitted | None:
    """The coefficients; None where something else would have to be beyond its limit of physics beside them.

    A friction that needs the viscous friction to be negative is not that friction; by a tenth of its own
    torque it may, since no formula is better.

    Args:
        prediction: Without it.
        apart: By how much less the other unknowns are per unit of each coefficient, shape (b, p).
        matrix: Normal matrix of the coefficients beside the others, shape (p, p).
        columns: Of the coefficients.
        one: The coefficients.
    """
    places = prediction.rows.limited
    if one is None or not len(places):
        return one
    lower, before = prediction.rows.least[places], prediction.values[places]
    after = before - apart[places] @ one.values
    free = matrix[np.ix_(one.free, one.free)] + np.diag(one.precision[one.free])
    moved = apart[np.ix_(places, one.free)]
    own = np.sum(moved * np.linalg.solve(free, moved.T).T, axis=1)
    std = np.sqrt(prediction.limited_std**2 + np.maximum(own, 0.0))
    below = np.minimum(lower, before) - STRANGE * std - after
    if not np.any(below > 0.0):
        return one
    torque = float(rms_torque((columns.values @ one.values)[:, :, None])[0])
    return None if np.any(below > FORMULA * torque / np.maximum(prediction.limited_size, 1e-300)) else one


def solved(matrix: np.ndarray, right: np.ndarray, values: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Unknowns of small systems (..., p, p), (..., p): some of them free (p,), the others at their values."""
    held = np.where(free, 0.0, values)
    right = np.where(free, right - matrix @ held, 0.0)
    size = np.sqrt(np.maximum(np.diagonal(matrix, axis1=-2, axis2=-1), 1e-300))
    scaled = np.where(
        np.outer(free, free), matrix / (size[..., :, None] * size[..., None, :]), np.eye(len(free))
    )
    scaled = scaled + 1e-10 * np.eye(len(free))
    return np.where(free, np.linalg.solve(scaled, (right / size)[..., None])[..., 0] / size, held)
