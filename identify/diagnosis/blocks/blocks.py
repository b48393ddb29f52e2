"""Blocks: pieces of runs, each of which can be left out and predicted, and sums of products over them."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from ..runs.driven import Driven, slices
from ..runs.rows import Rows

SECONDS = 2.0
"""Length of a block [s]: several times as long as what is left of a model remembers, a second at most."""
FEWEST, MOST = 16, 24
"""Blocks that all fitted runs are cut into: enough to give scatter to a fifth (16), and no more than give
it to a seventh (24). Short logs have shorter blocks, long ones longer."""
SHORTEST = 0.3
"""Length of the shortest block [s]: five times what the residual of a joint remembers, some 50 ms."""


@dataclass(frozen=True, eq=False)
class Blocks:
    """Pieces of the rows of some runs."""

    number: np.ndarray  # block of each row, shape (r,)
    rows: tuple[slice, ...]  # rows of each block
    fitted: np.ndarray  # whether a block is of a fitted run, shape (k,); else it is only predicted
    seconds: float  # length of a fitted block [s]

    @classmethod
    def of(cls, runs: Sequence[Driven], held_out: str) -> "Blocks":
        """Cut runs; those of role `held_out` are only predicted."""
        durations = [run.rows * period(run) for run in runs]
        total = sum(d for d, run in zip(durations, runs, strict=True) if run.role != held_out)
        length = max(SHORTEST, min(SECONDS, total / FEWEST), total / MOST)
        found: list[slice] = []
        fitted: list[bool] = []
        for run, own, duration in zip(runs, slices(runs), durations, strict=True):
            count = max(1, round(duration / length))
            edges = own.start + np.arange(count + 1) * run.rows // count
            found += [slice(int(a), int(b)) for a, b in zip(edges[:-1], edges[1:], strict=True)]
            fitted += [run.role != held_out] * count
        number = np.repeat(np.arange(len(found)), [piece.stop - piece.start for piece in found])
        return cls(number, tuple(found), np.array(fitted), length)

    def __len__(self) -> int:
        return len(self.rows)


def period(run: Driven) -> float:
    """Time between rows [s]."""
    return 1.0 / run.prepared.decimation.output_rate


@dataclass(frozen=True, eq=False)
class BlockSums:
    """Products over the rows that count; lists have an entry for each joint."""

    pieces: tuple[slice, ...]  # rows of each block
    acting: list[np.ndarray]  # unknowns that give torque to the joint, (a,)
    columns: list[np.ndarray]  # columns of those unknowns, (r, a)
    torque: list[np.ndarray]  # what they are to explain, (r,)
    gram: list[np.ndarray]  # products of columns of each block, (k, a, a)
    right: list[np.ndarray]  # products of columns and torque of each block, (k, a)
    counts: np.ndarray  # rows that count, shape (k, n)
    base: int = 0  # number of unknowns that `known` is about: those without any finding
    # products of candidates with the columns of those unknowns, by candidate columns; all sums that are made
    # of these by `plus` share them
    known: WeakKeyDictionary[Any, Any] = field(default_factory=WeakKeyDictionary)

    @classmethod
    def of(cls, rows: Rows, blocks: Blocks) -> "BlockSums":
        """Products of all rows and unknowns."""
        joints, pieces = range(rows.difference.shape[1]), blocks.rows
        nothing = cls(
            pieces,
            [np.zeros(0, int) for _ in joints],
            [np.zeros((len(rows.difference), 0)) for _ in joints],
            [rows.difference[:, j] * rows.weight[:, j] for j in joints],
            [np.zeros((len(pieces), 0, 0)) for _ in joints],
            [np.zeros((len(pieces), 0)) for _ in joints],
            np.array([rows.weight[piece].sum(axis=0) for piece in pieces]),
        )
        return replace(nothing.plus(rows, 0), base=len(rows.std))

    def plus(self, rows: Rows, count: int) -> "BlockSums":
        """Products of rows with more unknowns behind the first `count`, which these are of."""
        acting, columns, gram, right = [], [], [], []
        for joint, own in enumerate(self.columns):
            places = count + np.flatnonzero(np.any(rows.columns[:, joint, count:], axis=0))
            new = rows.columns[:, joint, places] * rows.weight[:, joint, None]
            explained = by_block(self.pieces, new, self.torque[joint])
            acting.append(np.append(self.acting[joint], places))
            columns.append(np.concatenate([own, new], axis=1))
            gram.append(_bordered(self.pieces, own, new, self.gram[joint]))
            right.append(np.concatenate([self.right[joint], explained], axis=1))
        return replace(self, acting=acting, columns=columns, gram=gram, right=right)

    @property
    def square(self) -> np.ndarray:
        """Sum of squares of the torque of each block and joint, shape (k, n) [(N m)^2]."""
        return np.array([[float(y[piece] @ y[piece]) for y in self.torque] for piece in self.pieces])

    def whole(self, weight: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Products over all joints for each block, weighted (k, n): (k, b, b) and (k, b)."""
        gram, right = np.zeros((len(weight), count, count)), np.zeros((len(weight), count))
        for joint, acting in enumerate(self.acting):
            own = weight[:, joint, None]
            gram[:, acting[:, None], acting] += own[:, :, None] * self.gram[joint]
            right[:, acting] += own * self.right[joint]
        return gram, right

    def left(self, values: np.ndarray) -> np.ndarray:
        """What unknowns (b,) leave of the torque, zero where a row does not count, shape (r, n) [N m]."""
        joints = zip(self.columns, self.torque, self.acting, strict=True)
        return np.stack([y - own @ values[acting] for own, y, acting in joints], axis=1)

    def mixed(self, torque: np.ndarray, count: int) -> np.ndarray:
        """Products of the columns of all unknowns with another torque (r, n), shape (b,)."""
        found = np.zeros(count)
        for own, acting, y in zip(self.columns, self.acting, torque.T, strict=True):
            found[acting] += own.T @ y
        return found

    def errors(self, values: np.ndarray) -> np.ndarray:
        """Sums of squares that values (k, b), one set for each block, leave of it, shape (k, n)."""
        found = np.zeros(self.counts.shape)
        for joint, (own, y, acting) in enumerate(zip(self.columns, self.torque, self.acting, strict=True)):
            for block, piece in enumerate(self.pieces):
                left = y[piece] - own[piece] @ values[block, acting]
                found[block, joint] = left @ left
        return found


def by_block(pieces: Sequence[slice], left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Products left' right over the rows of each block: (r, a) and (r, ...) give (k, a, ...)."""
    return np.stack([left[piece].T @ right[piece] for piece in pieces])


def _bordered(pieces: Sequence[slice], own: np.ndarray, new: np.ndarray, gram: np.ndarray) -> np.ndarray:
    """Products of columns with themselves (k, a, a), from those (k, b, b) of the first of them."""
    mixed = by_block(pieces, own, new)
    above = np.concatenate([gram, mixed], axis=2)
    below = np.concatenate([mixed.transpose(0, 2, 1), by_block(pieces, new, new)], axis=2)
    return np.concatenate([above, below], axis=1)
