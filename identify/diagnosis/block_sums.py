"""Sums of products of columns and torques over each block and joint, from which blocks can be left out."""

from dataclasses import dataclass

import numpy as np

from .blocks import Blocks
from .rows import Rows


@dataclass(frozen=True, eq=False)
class BlockSums:
    """Products over the rows that count.

    Attributes:
        acting: Unknowns that give torque to each joint, (a,) each.
        columns: Columns of those unknowns in each block and joint, [k][n] of (v, a).
        torque: What they are to explain, [k][n] of (v,).
        gram: Products of columns, [k][n] of (a, a).
        right: Products of columns and torque, [k][n] of (a,).
        counts: Rows that count, shape (k, n).
    """

    acting: list[np.ndarray]
    columns: list[list[np.ndarray]]
    torque: list[list[np.ndarray]]
    gram: list[list[np.ndarray]]
    right: list[list[np.ndarray]]
    counts: np.ndarray

    @classmethod
    def of(cls, rows: Rows, blocks: Blocks) -> "BlockSums":
        """Of all rows."""
        joints = range(rows.difference.shape[1])
        weighed = [rows.columns[:, j][:, rows.acting[j]] * rows.weight[:, j, None] for j in joints]
        target = rows.difference * rows.weight
        columns = [[weighed[j][piece] for j in joints] for piece in blocks.rows]
        torque = [[target[piece, j] for j in joints] for piece in blocks.rows]
        pairs = [list(zip(*both, strict=True)) for both in zip(columns, torque, strict=True)]
        return cls(
            rows.acting,
            columns,
            torque,
            [[own.T @ own for own, _ in block] for block in pairs],
            [[own.T @ y for own, y in block] for block in pairs],
            np.array([rows.weight[piece].sum(axis=0) for piece in blocks.rows]),
        )

    def whole(self, weight: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Products over all joints for each block, (k, b, b) and (k, b), by a weight (k, n)."""
        gram, right = np.zeros((len(weight), count, count)), np.zeros((len(weight), count))
        for block, own in enumerate(weight):
            for joint, acting in enumerate(self.acting):
                gram[block][np.ix_(acting, acting)] += own[joint] * self.gram[block][joint]
                right[block][acting] += own[joint] * self.right[block][joint]
        return gram, right

    def errors(self, values: np.ndarray) -> np.ndarray:
        """Sums of squares that values (k, b), one set for each block, leave of it, shape (k, n)."""
        left = [
            [y - own @ value[acting] for own, y, acting in zip(columns, torque, self.acting, strict=True)]
            for columns, torque, value in zip(self.columns, self.torque, values, strict=True)
        ]
        return np.array([[float(one @ one) for one in block] for block in left])
