"""Products of candidates' columns with everything else in the fit, over each block.

Products with the unknowns that every fit has are computed once for the same rows, and cached as long as the
columns exist. A fit with findings adds the products with the findings' columns.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..blocks.blocks import BlockSums, by_block
from ..blocks.prediction import Prediction
from .candidate import Thinned


class _Known(NamedTuple):
    """Cached products of one candidate's p columns on m joints, over each block."""

    gram: np.ndarray  # products with each other, shape (k, m, p, p)
    parts: list[np.ndarray]  # products with the columns of unknowns without findings, [m] of (k, p, a)
    by_torque: np.ndarray  # products with the torque to explain, shape (k, m, p)


@dataclass(frozen=True, eq=False)
class Products:
    """Products of i candidates' columns, p each, all on the same joints, over each block."""

    joints: np.ndarray  # joints that the candidates give torque to, shape (m,)
    places: np.ndarray  # unknowns of the prediction that give torque to any of these joints, shape (s,)
    gram: np.ndarray  # products of each candidate's columns with each other, by joint, (k, m, i, p, p)
    parts: list[np.ndarray]  # products with the prediction's columns, by joint, [m] of (k, i, p, a)
    by_torque: np.ndarray  # products with the torque to explain, by joint, shape (k, m, i, p)
    mixed: np.ndarray  # `parts` summed over joints with weights, shape (k, i, p, s)
    torque: np.ndarray  # `by_torque` summed over joints with weights, shape (k, i, p)
    weighted: np.ndarray  # `gram` summed over joints with weights, shape (k, i, p, p)

    @classmethod
    def of(cls, prediction: Prediction, alike: Sequence[Thinned]) -> "Products":
        """Compute the products of candidates over all blocks."""
        sums, joints = prediction.sums, alike[0].joints
        known = list(_known(prediction, alike))
        gram = np.stack([products.gram for products in known], axis=2)
        by_torque = np.stack([products.by_torque for products in known], axis=2)
        parts = [
            np.concatenate(
                [
                    np.stack([products.parts[place] for products in known], axis=1),
                    *_with_findings(prediction, alike, place),
                ],
                axis=3,
            )
            for place in range(len(joints))
        ]
        weight = prediction.weighting.weight[:, joints]
        places, mixed = _mixed(sums, joints, parts, weight)
        torque = np.einsum("km,kmip->kip", weight, by_torque)
        weighted = np.einsum("km,kmipq->kipq", weight, gram)
        return cls(joints, places, gram, parts, by_torque, mixed, torque, weighted)


def _known(prediction: Prediction, alike: Sequence[Thinned]) -> Iterator[_Known]:
    """Products of each candidate with the unknowns without findings; missing ones are computed together."""
    known = prediction.sums.known
    new = [columns for columns in dict.fromkeys(alike) if columns not in known]
    if new:
        known.update(zip(new, _formed(prediction, new), strict=True))
    return (known[columns] for columns in alike)


def _formed(prediction: Prediction, alike: Sequence[Thinned]) -> Iterator[_Known]:
    sums, joints, count = prediction.sums, alike[0].joints, alike[0].values.shape[2]
    grams, parts, torques = [], [], []
    for place, joint in enumerate(joints):
        values = _weighted(prediction, alike, place)
        base = sums.columns[joint][:, : _base(sums, joint)]
        shape = (len(sums.pieces), len(alike), count)
        parts.append(by_block(sums.pieces, values, base).reshape(*shape, -1))
        torques.append(by_block(sums.pieces, values, sums.torque[joint]).reshape(shape))
        grams.append(_with_itself(sums.pieces, values.reshape(-1, *shape[1:])))
    for number in range(len(alike)):
        yield _Known(
            np.stack([gram[:, number] for gram in grams], axis=1),
            [part[:, number] for part in parts],
            np.stack([torque[:, number] for torque in torques], axis=1),
        )


def _with_findings(prediction: Prediction, alike: Sequence[Thinned], place: int) -> list[np.ndarray]:
    """Products on one joint with the columns of findings, (k, i, p, q); empty without findings."""
    sums, joint = prediction.sums, alike[0].joints[place]
    more = sums.columns[joint][:, _base(sums, joint) :]
    if not more.shape[1]:
        return []
    values = _weighted(prediction, alike, place)
    return [by_block(sums.pieces, values, more).reshape(len(sums.pieces), len(alike), -1, more.shape[1])]


def _base(sums: BlockSums, joint: int) -> int:
    """Number of columns on a joint that do not belong to findings."""
    return int(np.searchsorted(sums.acting[joint], sums.base))


def _weighted(prediction: Prediction, alike: Sequence[Thinned], place: int) -> np.ndarray:
    """Weighted columns of all candidates on one of their joints, shape (r, i p)."""
    rows = np.concatenate([columns.values[:, place].T for columns in alike])
    rows *= prediction.rows.weight[:, alike[0].joints[place]]
    return rows.T  # each column is contiguous, as in `Thinned`


def _mixed(
    sums: BlockSums, joints: np.ndarray, parts: Sequence[np.ndarray], weight: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Unknowns (s,) that give torque to any of some joints, and weighted products with them (k, i, p, s)."""
    if len(joints) == 1:
        return sums.acting[joints[0]], weight[:, 0, None, None, None] * parts[0]
    places = np.unique(np.concatenate([sums.acting[joint] for joint in joints]))
    mixed = np.zeros((*parts[0].shape[:3], len(places)))
    for place, joint in enumerate(joints):
        acting = np.searchsorted(places, sums.acting[joint])
        mixed[..., acting] += weight[:, place, None, None, None] * parts[place]
    return places, mixed


def _with_itself(pieces: Sequence[slice], values: np.ndarray) -> np.ndarray:
    """Products of each candidate's columns (r, i, p) with each other, shape (k, i, p, p)."""
    blocks = (values[piece].transpose(1, 2, 0) for piece in pieces)
    return np.stack([block @ block.transpose(0, 2, 1) for block in blocks])
