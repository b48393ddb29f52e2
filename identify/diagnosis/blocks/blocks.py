"""Blocks: pieces of runs that can each be left out and predicted, and their rows.

A block contains all rows with the same motion, so that no lap of a repeated motion predicts another one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..runs.driven import Driven, slices
from ..runs.rows import Rows
from .repeated_motion import first_rows

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
    fitted: np.ndarray  # whether a block belongs to a fitted run, shape (k,); others are held out
    first: np.ndarray  # row in which the motion of each row was made for the first time, shape (r,)
    seconds: float  # duration of a fitted block, in one lap [s]

    @classmethod
    def of(cls, runs: Sequence[Driven], held_out: str) -> "Blocks":
        """Cut runs into blocks; runs with the role `held_out` are only predicted."""
        first = first_rows(runs)
        new, each = first == np.arange(len(first)), slices(runs)
        pieces = [rows.start + np.flatnonzero(new[rows]) for rows in each]
        durations = [period(run) * len(piece) for run, piece in zip(runs, pieces, strict=True)]
        total = sum(d for d, run in zip(durations, runs, strict=True) if run.role != held_out)
        seconds = max(SHORTEST, min(SECONDS, total / FEWEST), total / MOST)
        number, fitted = np.full(len(first), -1), list[bool]()
        for run, rows, piece, duration in zip(runs, each, pieces, durations, strict=True):
            alone = np.all(first[rows] >= rows.start)
            if count := max(round(duration / seconds), int(alone)):
                lengths = np.diff(np.arange(count + 1) * len(piece) // count)
                number[piece] = len(fitted) + np.repeat(np.arange(count), lengths)
                fitted += [run.role != held_out] * count
            number[rows] = number[first[rows]]
            # What is too short for a block of its own joins the next one.
            known = rows.start + np.flatnonzero(number[rows] >= 0)
            following = np.searchsorted(known, np.arange(rows.start, rows.stop))
            number[rows] = number[known[np.minimum(following, len(known) - 1)]]
        return cls(number, np.array(fitted), first, seconds)

    def __len__(self) -> int:
        return len(self.fitted)

    @cached_property
    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """Block of each row, and its place there, both (r,)."""
        order = np.argsort(self.number, kind="stable")
        starts = np.cumsum([0, *np.bincount(self.number, minlength=len(self))])[:-1]
        place = np.empty(len(order), int)
        place[order] = np.arange(len(order)) - starts[self.number[order]]
        return self.number, place

    @property
    def laps(self) -> float:
        """How often the motion of the fitted runs was made, on average."""
        first = self.first[self.fitted[self.number]]
        return len(first) / max(len(np.unique(first)), 1)

    def sums(self, values: np.ndarray) -> np.ndarray:
        """Sums of values (r, n) over the rows of each block, shape (k, n)."""
        return np.stack([np.bincount(self.number, column, len(self)) for column in values.T], axis=1)


def period(run: Driven) -> float:
    """Time between rows [s]."""
    return 1.0 / run.prepared.decimation.output_rate


@dataclass(frozen=True, eq=False)
class BlockRows:
    """Rows arranged by block; places that hold no row, or a row that does not count, are zero.

    Each block has l places, as many as the longest has rows. Lists have one entry per joint.
    """

    shape: tuple[int, int]  # number of blocks, and of places in each: k, l
    places: tuple[np.ndarray, np.ndarray]  # block of each row, and its place there, both (r,)
    acting: list[np.ndarray]  # unknowns that give torque to the joint, (a,)
    columns: list[np.ndarray]  # columns of those unknowns, (k, l, a)
    torque: np.ndarray  # torque to explain, shape (k, n, l)
    counts: np.ndarray  # number of rows that count, shape (k, n)

    @classmethod
    def of(cls, rows: Rows, blocks: Blocks) -> "BlockRows":
        """Arrange all rows and unknowns."""
        shape = len(blocks), int(np.bincount(blocks.number).max())
        joints = range(rows.difference.shape[1])
        empty = cls(
            shape,
            blocks.places,
            [np.zeros(0, int) for _ in joints],
            [np.zeros((*shape, 0)) for _ in joints],
            np.zeros((shape[0], len(joints), shape[1])),
            blocks.sums(rows.weight),
        )
        torque = np.moveaxis(empty._padded(rows.difference * rows.weight), 2, 1)
        empty = replace(empty, torque=torque)
        return empty.plus(rows, 0)

    def plus(self, rows: Rows, count: int) -> "BlockRows":
        """The rows with more unknowns after the first `count`, which these rows contain."""
        acting, columns, added = [], [], rows.columns_at(np.arange(count, len(rows.std)))
        for joint, present in enumerate(self.columns):
            places = np.flatnonzero(np.any(added[:, joint], axis=0))
            new = added[:, joint, places] * rows.weight[:, joint, None]
            acting.append(np.append(self.acting[joint], count + places))
            columns.append(np.concatenate([present, self._padded(new)], axis=2))
        return replace(self, acting=acting, columns=columns)

    @cached_property
    def squares(self) -> list[np.ndarray]:
        """Products of the columns of each joint in each block, [n] of (k, a, a)."""
        return [np.swapaxes(columns, 1, 2) @ columns for columns in self.columns]

    @cached_property
    def products(self) -> list[np.ndarray]:
        """Products of the columns of each joint with the torque to explain, [n] of (k, a)."""
        joints = enumerate(self.columns)
        return [(self.torque[:, joint, None] @ columns)[:, 0] for joint, columns in joints]

    def arranged(self, values: np.ndarray) -> np.ndarray:
        """Values (..., r) of rows in sequence, arranged by block, shape (k, ..., l)."""
        arranged = np.zeros((self.shape[0], *values.shape[:-1], self.shape[1]))
        block, place = self.places
        arranged[block, ..., place] = np.moveaxis(values, -1, 0)
        return arranged

    def in_sequence(self, values: np.ndarray) -> np.ndarray:
        """Values (k, n, l) of all blocks as rows (r, n)."""
        block, place = self.places
        return np.asarray(values[block, :, place])

    def mixed(self, torque: np.ndarray, count: int) -> np.ndarray:
        """Products of the columns of all unknowns with another torque (r, n), shape (b,)."""
        products, torque = np.zeros(count), self._padded(torque)
        for joint, (columns, acting) in enumerate(zip(self.columns, self.acting, strict=True)):
            products[acting] += torque[:, :, joint].ravel() @ columns.reshape(-1, len(acting))
        return products

    def residual(self, values: np.ndarray) -> np.ndarray:
        """Residual of the torque with unknowns (b,), or (k, b) if each block has its own, shape (k, n, l)."""
        each = np.broadcast_to(values, (self.shape[0], values.shape[-1]))[:, :, None]
        joints = zip(self.columns, self.acting, strict=True)
        explained = [(columns @ each[:, acting])[:, :, 0] for columns, acting in joints]
        return np.asarray(self.torque - np.stack(explained, axis=1))

    def errors(self, values: np.ndarray) -> np.ndarray:
        """Squared residual of each block with its own set of unknowns (k, b), shape (k, n) [(N m)^2]."""
        return np.asarray(np.square(self.residual(values)).sum(axis=2))

    def _padded(self, values: np.ndarray) -> np.ndarray:
        """Rows (r, ...) arranged in blocks, shape (k, l, ...)."""
        padded = np.zeros((*self.shape, *values.shape[1:]))
        padded[self.places] = values
        return padded
