"""Products of candidates' columns with themselves, with the prediction's, and with the torque."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..blocks.block_sums import by_block
from ..blocks.prediction import Prediction
from .candidate import Thinned


@dataclass(frozen=True, eq=False)
class Products:
    """Products of i candidates' columns, p each, all of the same joints, over each block.

    Attributes:
        joints: Those they give torque to, shape (m,).
        own: Columns of each candidate with each other, shape (k, m, i, p, p).
        parts: With the prediction's columns, of each joint, [m] of (k, a, i, p).
        by_torque: With what is to be explained, of each joint, shape (k, m, i, p).
        mixed: With the prediction's, all joints weighted, shape (k, b, i, p).
        torque: With what is to be explained, likewise, shape (k, i, p).
        weighted: `own` over all joints, weighted, shape (k, i, p, p).
    """

    joints: np.ndarray
    own: np.ndarray
    parts: list[np.ndarray]
    by_torque: np.ndarray
    mixed: np.ndarray
    torque: np.ndarray
    weighted: np.ndarray

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
    found = []
    for piece in pieces:
        own = values[piece].transpose(1, 2, 0)
        found.append(own @ own.transpose(0, 2, 1))
    return np.stack(found)
