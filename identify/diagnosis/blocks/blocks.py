"""Blocks: pieces of runs that can each be left out and predicted, and sums of products over them."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from ..runs.driven import Driven, slices
from ..runs.rows import Rows

SECONDS = 2.0
"""Duration of a block [s]: several times the correlation time of a residual, which is at most a second."""
FEWEST, MOST = 16, 24
"""Number of blocks of all fitted runs: enough to estimate scatter to a fifth (16), and no more than for a
seventh (24). Short logs have shorter blocks, and long logs longer ones."""
SHORTEST = 0.3
"""Shortest duration of a block [s]: five times the correlation time of a residual, about 50 ms."""


@dataclass(frozen=True, eq=False)
class Blocks:
    """Pieces of the rows of runs."""

    number: np.ndarray  # block of each row, shape (r,)
    rows: tuple[slice, ...]  # rows of each block
    fitted: np.ndarray  # whether a block belongs to a fitted run, shape (k,); others are held out
    seconds: float  # duration of a fitted block [s]

    @classmethod
    def of(cls, runs: Sequence[Driven], held_out: str) -> "Blocks":
        """Cut runs into blocks; runs with the role `held_out` are only predicted."""
        durations = [run.rows * period(run) for run in runs]
        total = sum(d for d, run in zip(durations, runs, strict=True) if run.role != held_out)
        seconds = max(SHORTEST, min(SECONDS, total / FEWEST), total / MOST)
        pieces: list[slice] = []
        fitted: list[bool] = []
        for run, rows, duration in zip(runs, slices(runs), durations, strict=True):
            count = max(1, round(duration / seconds))
            edges = rows.start + np.arange(count + 1) * run.rows // count
            pieces += [slice(int(a), int(b)) for a, b in zip(edges[:-1], edges[1:], strict=True)]
            fitted += [run.role != held_out] * count
        number = np.repeat(np.arange(len(pieces)), [piece.stop - piece.start for piece in pieces])
        return cls(number, tuple(pieces), np.array(fitted), seconds)

    def __len__(self) -> int:
        return len(self.rows)


def period(run: Driven) -> float:
    """Time between rows [s]."""
    return 1.0 / run.prepared.decimation.output_rate


@dataclass(frozen=True, eq=False)
class BlockSums:
    """Products over the rows that count; each list has one entry per joint."""

    pieces: tuple[slice, ...]  # rows of each block
    acting: list[np.ndarray]  # unknowns that give torque to the joint, (a,)
    columns: list[np.ndarray]  # columns of those unknowns, (r, a)
    torque: list[np.ndarray]  # torque to explain, (r,)
    gram: list[np.ndarray]  # products of columns over each block, (k, a, a)
    right: list[np.ndarray]  # products of columns and torque over each block, (k, a)
    counts: np.ndarray  # number of rows that count, shape (k, n)
    base: int = 0  # number of unknowns without findings, which `known` is about
    # cached products of candidates with the columns of these unknowns, by candidate columns; sums that `plus`
    # derives from these share the cache
    known: WeakKeyDictionary[Any, Any] = field(default_factory=WeakKeyDictionary)

    @classmethod
    def of(cls, rows: Rows, blocks: Blocks) -> "BlockSums":
        """Compute the products of all rows and unknowns."""
        joints, pieces = range(rows.difference.shape[1]), blocks.rows
        empty = cls(
            pieces,
            [np.zeros(0, int) for _ in joints],
            [np.zeros((len(rows.difference), 0)) for _ in joints],
            [rows.difference[:, j] * rows.weight[:, j] for j in joints],
            [np.zeros((len(pieces), 0, 0)) for _ in joints],
            [np.zeros((len(pieces), 0)) for _ in joints],
            np.array([rows.weight[piece].sum(axis=0) for piece in pieces]),
        )
        return replace(empty.plus(rows, 0), base=len(rows.std))

    def plus(self, rows: Rows, count: int) -> "BlockSums":
        """Products of rows with more unknowns after the first `count`, which these products contain."""
        acting, columns, gram, right = [], [], [], []
        for joint, present in enumerate(self.columns):
            places = count + np.flatnonzero(np.any(rows.columns[:, joint, count:], axis=0))
            new = rows.columns[:, joint, places] * rows.weight[:, joint, None]
            explained = by_block(self.pieces, new, self.torque[joint])
            acting.append(np.append(self.acting[joint], places))
            columns.append(np.concatenate([present, new], axis=1))
            gram.append(_bordered(self.pieces, present, new, self.gram[joint]))
            right.append(np.concatenate([self.right[joint], explained], axis=1))
        return replace(self, acting=acting, columns=columns, gram=gram, right=right)

    @property
    def square(self) -> np.ndarray:
        """Sum of squares of the torque of each block and joint, shape (k, n) [(N m)^2]."""
        return np.array([[float(y[piece] @ y[piece]) for y in self.torque] for piece in self.pieces])

    def normal_equations(self, weight: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Matrices (k, b, b) and right-hand sides (k, b) of each block, all joints weighted (k, n)."""
        gram, right = np.zeros((len(weight), count, count)), np.zeros((len(weight), count))
        for joint, acting in enumerate(self.acting):
            factor = weight[:, joint, None]
            gram[:, acting[:, None], acting] += factor[:, :, None] * self.gram[joint]
            right[:, acting] += factor * self.right[joint]
        return gram, right

    def residual(self, values: np.ndarray) -> np.ndarray:
        """Residual of the torque with unknowns (b,), zero where a row does not count, shape (r, n) [N m]."""
        joints = zip(self.columns, self.torque, self.acting, strict=True)
        return np.stack([y - columns @ values[acting] for columns, y, acting in joints], axis=1)

    def mixed(self, torque: np.ndarray, count: int) -> np.ndarray:
        """Products of the columns of all unknowns with another torque (r, n), shape (b,)."""
        products = np.zeros(count)
        for columns, acting, y in zip(self.columns, self.acting, torque.T, strict=True):
            products[acting] += columns.T @ y
        return products

    def errors(self, values: np.ndarray) -> np.ndarray:
        """Squared residual of each block with its own set of unknowns (k, b), shape (k, n) [(N m)^2]."""
        joints = [self.joint_errors(joint, values[:, acting]) for joint, acting in enumerate(self.acting)]
        return np.stack(joints, axis=1)

    def joint_errors(self, joint: int, values: np.ndarray) -> np.ndarray:
        """Squared residual of one joint in each block with its acting unknowns (k, a), shape (k,)."""
        columns, torque, pieces = self.columns[joint], self.torque[joint], self.pieces
        residuals = (torque[p] - columns[p] @ v for p, v in zip(pieces, values, strict=True))
        return np.array([residual @ residual for residual in residuals])


def by_block(pieces: Sequence[slice], left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Products left' right over the rows of each block, of (r, a) and (r, ...), shape (k, a, ...)."""
    return np.stack([left[piece].T @ right[piece] for piece in pieces])


def _bordered(pieces: Sequence[slice], present: np.ndarray, new: np.ndarray, gram: np.ndarray) -> np.ndarray:
    """Gram matrices of present and new columns (k, a, a), from those of the present columns (k, b, b)."""
    mixed = by_block(pieces, present, new)
    above = np.concatenate([gram, mixed], axis=2)
    below = np.concatenate([mixed.transpose(0, 2, 1), by_block(pieces, new, new)], axis=2)
    return np.concatenate([above, below], axis=1)
