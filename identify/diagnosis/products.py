"""Products of candidates' columns with themselves, with the prediction's, and with the torque."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .candidate import Thinned
from .prediction import Prediction


@dataclass(frozen=True, eq=False)
class Products:
    """Products of candidates' columns, all of the same joints, with themselves and with the prediction's.

    Attributes:
        joints: Those they give torque to, shape (m,).
        places: Columns of each candidate among all c of them.
        own: Columns with each other, of each block and joint, shape (k, m, c, c).
        parts: With the prediction's columns (a, c) and with the torque (c,) of each block and joint.
        mixed: With the prediction's, of each block, all joints weighted, shape (k, b, c).
        torque: With what is to be explained, likewise, shape (k, c).
        weighted: `own` over all joints, weighted, shape (k, c, c).
    """

    joints: np.ndarray
    places: list[np.ndarray]
    own: np.ndarray
    parts: list[list[tuple[np.ndarray, np.ndarray]]]
    mixed: np.ndarray
    torque: np.ndarray
    weighted: np.ndarray

    @classmethod
    def of(cls, prediction: Prediction, every: Sequence[Thinned]) -> "Products":
        """Over all blocks."""
        sums, weight, joints = prediction.sums, prediction.weighting.weight, every[0].joints
        stops = np.cumsum([0, *(one.values.shape[2] for one in every)])
        values = np.concatenate([one.values for one in every], axis=2)
        values = values * prediction.rows.weight[:, joints, None]
        blocks, count = prediction.blocks.rows, values.shape[2]
        pieces = [values[rows].transpose(1, 0, 2) for rows in blocks]
        own = np.stack([piece.transpose(0, 2, 1) @ piece for piece in pieces])
        mixed, torque = (
            np.zeros((len(blocks), len(prediction.rows.std), count)),
            np.zeros((len(blocks), count)),
        )
        parts: list[list[tuple[np.ndarray, np.ndarray]]] = []
        for block, piece in enumerate(pieces):
            parts.append([])
            for one, joint in zip(piece, joints, strict=True):
                by_columns = sums.columns[block][joint].T @ one
                by_torque = one.T @ sums.torque[block][joint]
                parts[-1].append((by_columns, by_torque))
                mixed[block][sums.acting[joint]] += weight[block, joint] * by_columns
                torque[block] += weight[block, joint] * by_torque
        weighted = np.einsum("km,kmpq->kpq", weight[:, joints], own)
        places = [np.arange(a, b) for a, b in zip(stops[:-1], stops[1:], strict=True)]
        return cls(joints, places, own, parts, mixed, torque, weighted)
