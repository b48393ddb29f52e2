"""Blocks: pieces of runs that can each be left out and predicted, and their rows."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

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
class BlockRows:
    """Rows arranged by block; places that hold no row, or a row that does not count, are zero.

    Each block has l places, as many as the longest has rows. Lists have one entry per joint.
    """

    inside: np.ndarray  # which places of a block hold a row, shape (k, l)
    acting: list[np.ndarray]  # unknowns that give torque to the joint, (a,)
    columns: list[np.ndarray]  # columns of those unknowns, (k, l, a)
    torque: np.ndarray  # torque to explain, shape (k, n, l)
    counts: np.ndarray  # number of rows that count, shape (k, n)

    @classmethod
    def of(cls, rows: Rows, blocks: Blocks) -> "BlockRows":
        """Arrange all rows and unknowns."""
        lengths = np.array([piece.stop - piece.start for piece in blocks.rows])
        inside = np.arange(max(lengths)) < lengths[:, None]
        joints = range(rows.difference.shape[1])
        empty = cls(
            inside,
            [np.zeros(0, int) for _ in joints],
            [np.zeros((*inside.shape, 0)) for _ in joints],
            np.moveaxis(_padded(inside, rows.difference * rows.weight), 2, 1),
            _padded(inside, rows.weight).sum(axis=1),
        )
        return empty.plus(rows, 0)

    def plus(self, rows: Rows, count: int) -> "BlockRows":
        """The rows with more unknowns after the first `count`, which these rows contain."""
        acting, columns, added = [], [], rows.columns_at(np.arange(count, len(rows.std)))
        for joint, present in enumerate(self.columns):
            places = np.flatnonzero(np.any(added[:, joint], axis=0))
            new = added[:, joint, places] * rows.weight[:, joint, None]
            acting.append(np.append(self.acting[joint], count + places))
            columns.append(np.concatenate([present, _padded(self.inside, new)], axis=2))
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
        arranged = np.zeros((len(self.inside), *values.shape[:-1], self.inside.shape[1]))
        lengths, start = self.inside.sum(axis=1).tolist(), 0
        for block, length in zip(arranged, lengths, strict=True):
            block[..., :length] = values[..., start : start + length]
            start += length
        return arranged

    def in_sequence(self, values: np.ndarray) -> np.ndarray:
        """Values (k, n, l) of all blocks as rows (r, n)."""
        return np.asarray(np.moveaxis(values, 1, 2)[self.inside])

    def mixed(self, torque: np.ndarray, count: int) -> np.ndarray:
        """Products of the columns of all unknowns with another torque (r, n), shape (b,)."""
        products, torque = np.zeros(count), _padded(self.inside, torque)
        for joint, (columns, acting) in enumerate(zip(self.columns, self.acting, strict=True)):
            products[acting] += torque[:, :, joint].ravel() @ columns.reshape(-1, len(acting))
        return products

    def residual(self, values: np.ndarray) -> np.ndarray:
        """Residual of the torque with unknowns (b,), or (k, b) if each block has its own, shape (k, n, l)."""
        each = np.broadcast_to(values, (len(self.inside), values.shape[-1]))[:, :, None]
        joints = zip(self.columns, self.acting, strict=True)
        explained = [(columns @ each[:, acting])[:, :, 0] for columns, acting in joints]
        return np.asarray(self.torque - np.stack(explained, axis=1))

    def errors(self, values: np.ndarray) -> np.ndarray:
        """Squared residual of each block with its own set of unknowns (k, b), shape (k, n) [(N m)^2]."""
        return np.asarray(np.square(self.residual(values)).sum(axis=2))


def _padded(inside: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Rows (r, ...) arranged in blocks, shape (k, l, ...)."""
    padded = np.zeros((*inside.shape, *values.shape[1:]))
    padded[inside] = values
    return padded
