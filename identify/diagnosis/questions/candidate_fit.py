"""Candidate fit: products of candidates' columns, and their coefficients within what physics allows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..blocks.blocks import by_block
from ..blocks.prediction import Prediction, rms_torque
from .block_answer import STRANGE, prior_std
from .candidate import Candidate, Thinned


@dataclass(frozen=True, eq=False)
class Products:
    """Products of i candidates' columns, p each, all of the same joints, over each block."""

    joints: np.ndarray  # those they give torque to, shape (m,)
    own: np.ndarray  # columns of each candidate with each other, shape (k, m, i, p, p)
    parts: list[np.ndarray]  # with the prediction's columns, of each joint, [m] of (k, a, i, p)
    by_torque: np.ndarray  # with what is to be explained, of each joint, shape (k, m, i, p)
    mixed: np.ndarray  # with the prediction's, all joints weighted, shape (k, b, i, p)
    torque: np.ndarray  # with what is to be explained, likewise, shape (k, i, p)
    weighted: np.ndarray  # `own` over all joints, weighted, shape (k, i, p, p)

    @classmethod
    def of(cls, prediction: Prediction, every: Sequence[Thinned]) -> "Products":
        """Over all blocks."""
        sums, joints, pieces = prediction.sums, every[0].joints, prediction.blocks.rows
        values = [np.stack([one.values[:, place] for one in every], axis=1) for place in range(len(joints))]
        values = [
            own * prediction.rows.weight[:, joint, None, None]
            for own, joint in zip(values, joints, strict=True)
        ]
        shape = (len(pieces), -1, len(every), every[0].values.shape[2])
        flat = [own.reshape(len(own), -1) for own in values]
        parts = [
            by_block(pieces, sums.columns[joint], own).reshape(shape)
            for joint, own in zip(joints, flat, strict=True)
        ]
        own = np.stack([_with_itself(pieces, one) for one in values], axis=1)
        by_torque = np.stack(
            [
                by_block(pieces, one, sums.torque[joint]).reshape(shape[0], *shape[2:])
                for joint, one in zip(joints, flat, strict=True)
            ],
            axis=1,
        )
        weight = prediction.weighting.weight[:, joints]
        mixed = np.zeros((shape[0], len(prediction.rows.std), *shape[2:]))
        for place, joint in enumerate(joints):
            mixed[:, sums.acting[joint]] += weight[:, place, None, None, None] * parts[place]
        torque = np.einsum("km,kmip->kip", weight, by_torque)
        return cls(joints, own, parts, by_torque, mixed, torque, np.einsum("km,kmipq->kipq", weight, own))


def _with_itself(pieces: Sequence[slice], values: np.ndarray) -> np.ndarray:
    """Products of columns (r, i, p) of each candidate, shape (k, i, p, p)."""
    every = (values[piece].transpose(1, 2, 0) for piece in pieces)
    return np.stack([own @ own.transpose(0, 2, 1) for own in every])


FORMULA = 0.1
"""Error of a formula of friction or gears, share of its torque [-]: none is right to better than a tenth."""


class Fitted(NamedTuple):
    """Coefficients of one candidate by all fitted blocks (p,), which of them are free, and their priors."""

    values: np.ndarray
    free: np.ndarray
    precision: np.ndarray
    mean: np.ndarray


def fitted(matrix: np.ndarray, right: np.ndarray, candidate: Candidate, columns: Thinned) -> Fitted | None:
    """Coefficients of one candidate, held at their limits of physics; None where the effect cannot be."""
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
        prediction: Without the candidate.
        apart: By how much less the other unknowns are per unit of each coefficient, shape (b, p).
        matrix: Normal matrix of the coefficients beside the others, shape (p, p).
        columns: Columns of the candidate.
        one: The coefficients.
    """
    places = prediction.rows.limited
    if one is None or not len(places):
        return one
    lower, before = prediction.rows.lower[places], prediction.values[places]
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
