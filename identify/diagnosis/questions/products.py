"""Products: those of candidates' columns with everything else in the fit, over each block.

Products with the unknowns that every fit has are formed once for the same rows, and kept as long as the
columns. A fit with findings adds the products with the findings' columns.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..blocks.blocks import BlockSums, by_block
from ..blocks.prediction import Prediction
from .candidate import Thinned


class _Known(NamedTuple):
    """Products of one candidate's p columns, m joints, over each block."""

    own: np.ndarray  # with each other, shape (k, m, p, p)
    parts: list[np.ndarray]  # with the columns of the unknowns without findings, [m] of (k, p, a)
    by_torque: np.ndarray  # with what is to be explained, shape (k, m, p)


@dataclass(frozen=True, eq=False)
class Products:
    """Products of i candidates' columns, p each, all of the same joints, over each block."""

    joints: np.ndarray  # those they give torque to, shape (m,)
    places: np.ndarray  # unknowns of the prediction that give torque to any of them, shape (s,)
    own: np.ndarray  # columns of each candidate with each other, shape (k, m, i, p, p)
    parts: list[np.ndarray]  # with the prediction's columns, of each joint, [m] of (k, i, p, a)
    by_torque: np.ndarray  # with what is to be explained, of each joint, shape (k, m, i, p)
    mixed: np.ndarray  # with the prediction's columns, all joints weighted, shape (k, i, p, s)
    torque: np.ndarray  # with what is to be explained, likewise, shape (k, i, p)
    weighted: np.ndarray  # `own` over all joints, weighted, shape (k, i, p, p)

    @classmethod
    def of(cls, prediction: Prediction, every: Sequence[Thinned]) -> "Products":
        """Over all blocks."""
        sums, joints = prediction.sums, every[0].joints
        known = list(_known(prediction, every))
        own = np.stack([one.own for one in known], axis=2)
        by_torque = np.stack([one.by_torque for one in known], axis=2)
        parts = [
            np.concatenate(
                [np.stack([one.parts[place] for one in known], axis=1), *_beside(prediction, every, place)],
                axis=3,
            )
            for place in range(len(joints))
        ]
        weight = prediction.weighting.weight[:, joints]
        places, mixed = _mixed(sums, joints, parts, weight)
        torque = np.einsum("km,kmip->kip", weight, by_torque)
        weighted = np.einsum("km,kmipq->kipq", weight, own)
        return cls(joints, places, own, parts, by_torque, mixed, torque, weighted)


def _known(prediction: Prediction, every: Sequence[Thinned]) -> Iterator[_Known]:
    """Products of each with the unknowns without findings; those that are new are formed together."""
    known = prediction.sums.known
    new = [one for one in dict.fromkeys(every) if one not in known]
    if new:
        known.update(zip(new, _formed(prediction, new), strict=True))
    return (known[one] for one in every)


def _formed(prediction: Prediction, every: Sequence[Thinned]) -> Iterator[_Known]:
    sums, joints, count = prediction.sums, every[0].joints, every[0].values.shape[2]
    own, parts, torque = [], [], []
    for place, joint in enumerate(joints):
        values = _weighted(prediction, every, place)
        base = sums.columns[joint][:, : _base(sums, joint)]
        shape = (len(sums.pieces), len(every), count)
        parts.append(by_block(sums.pieces, values, base).reshape(*shape, -1))
        torque.append(by_block(sums.pieces, values, sums.torque[joint]).reshape(shape))
        own.append(_with_itself(sums.pieces, values.reshape(-1, *shape[1:])))
    for number in range(len(every)):
        yield _Known(
            np.stack([one[:, number] for one in own], axis=1),
            [one[:, number] for one in parts],
            np.stack([one[:, number] for one in torque], axis=1),
        )


def _beside(prediction: Prediction, every: Sequence[Thinned], place: int) -> list[np.ndarray]:
    """Products on one joint with the columns of findings, (k, i, p, q); none without any."""
    sums, joint = prediction.sums, every[0].joints[place]
    more = sums.columns[joint][:, _base(sums, joint) :]
    if not more.shape[1]:
        return []
    values = _weighted(prediction, every, place)
    return [by_block(sums.pieces, values, more).reshape(len(sums.pieces), len(every), -1, more.shape[1])]


def _base(sums: BlockSums, joint: int) -> int:
    """Number of columns of a joint that are not of findings."""
    return int(np.searchsorted(sums.acting[joint], sums.base))


def _weighted(prediction: Prediction, every: Sequence[Thinned], place: int) -> np.ndarray:
    """Columns of all candidates on one of their joints as they count, shape (r, i p)."""
    rows = np.concatenate([one.values[:, place].T for one in every])
    rows *= prediction.rows.weight[:, every[0].joints[place]]
    return rows.T  # columns lie in a row each, as in `Thinned`


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
    """Products of columns (r, i, p) of each candidate, shape (k, i, p, p)."""
    every = (values[piece].transpose(1, 2, 0) for piece in pieces)
    return np.stack([own @ own.transpose(0, 2, 1) for own in every])
