"""Blocks: pieces of runs that can each be left out and predicted, and their rows.

A block contains all rows with the same motion, so that no lap of a repeated motion predicts another one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...preparation.repeated_motion import first_rows
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
    fitted: np.ndarray  # whether a block belongs to a fitted run, shape (k,); others are held out
    first: np.ndarray  # row in which the motion of each row was made for the first time, shape (r,)
    seconds: float  # duration of a fitted block, in one lap [s]

    @classmethod
    def of(cls, runs: Sequence[Driven], held_out: str) -> "Blocks":
        """Cut runs into blocks; runs with the role `held_out` are only predicted."""
        kinds = [(run.role, run.motion.payload) for run in runs]  # held-out runs test the fit of the others
        first = first_rows([run.motion.position[run.centres] for run in runs], kinds)
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
    def order(self) -> np.ndarray:
        """Rows sorted by block, (r,)."""
        return np.argsort(self.number, kind="stable")

    @cached_property
    def starts(self) -> np.ndarray:
        """Place of the first row of each block among the sorted rows, (k,)."""
        return np.searchsorted(self.number[self.order], np.arange(len(self)))

    @property
    def laps(self) -> float:
        """How often the motion of the fitted runs was made, on average."""
        first = self.first[self.fitted[self.number]]
        return len(first) / max(len(np.unique(first)), 1)


def period(run: Driven) -> float:
    """Time between rows [s]."""
    return 1.0 / run.prepared.decimation.output_rate


@dataclass(frozen=True, eq=False)
class BlockRows:
    """Rows sorted by block, zero where a row does not count. Lists have one entry per joint."""

    blocks: Blocks  # blocks of the rows
    acting: list[np.ndarray]  # unknowns that give torque to the joint, (a,)
    columns: list[np.ndarray]  # columns of those unknowns, (r, a)
    torque: np.ndarray  # torque to explain, shape (n, r)
    weight: np.ndarray  # 0 where a row does not count, else 1, shape (n, r)

    @classmethod
    def of(cls, rows: Rows, blocks: Blocks) -> "BlockRows":
        """Sort all rows and unknowns."""
        joints = range(rows.difference.shape[1])
        torque, weight = ((x * rows.weight)[blocks.order].T.copy() for x in (rows.difference, 1.0))
        acting, columns = [np.zeros(0, int) for _ in joints], [np.zeros((torque.shape[1], 0)) for _ in joints]
        return cls(blocks, acting, columns, torque, weight).plus(rows, 0)

    def plus(self, rows: Rows, count: int) -> "BlockRows":
        """The rows with more unknowns after the first `count`, which these rows contain."""
        acting, columns, added = [], [], rows.columns_at(np.arange(count, len(rows.std)))
        for joint, present in enumerate(self.columns):
            places = np.flatnonzero(np.any(added[:, joint], axis=0))
            new = added[:, joint, places] * rows.weight[:, joint, None]
            acting.append(np.append(self.acting[joint], count + places))
            columns.append(np.concatenate([present, new[self.blocks.order]], axis=1))
        return replace(self, acting=acting, columns=columns)

    @cached_property
    def squares(self) -> list[np.ndarray]:
        """Products of the columns of each joint in each block, [n] of (k, a, a)."""
        return [self.products_of(columns.T, columns) for columns in self.columns]

    @cached_property
    def products(self) -> list[np.ndarray]:
        """Products of the columns of each joint with the torque to explain, [n] of (k, a)."""
        each = zip(self.torque, self.columns, strict=True)
        return [self.products_of(torque[None], columns)[:, 0] for torque, columns in each]

    def products_of(self, values: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Products (k, a, b) in each block of sorted values (a, r) and columns (r, b)."""
        products = np.empty((len(self.blocks), len(values), columns.shape[1]))
        for block, rows in enumerate(self.spans):
            np.matmul(values[:, rows], columns[rows], out=products[block])
        return products

    @cached_property
    def counts(self) -> np.ndarray:
        """Number of rows that count, shape (k, n)."""
        return self.sums(self.weight)

    @cached_property
    def spans(self) -> list[slice]:
        """Sorted rows of each block."""
        ends = np.append(self.blocks.starts[1:], self.torque.shape[1])
        return [slice(int(a), int(b)) for a, b in zip(self.blocks.starts, ends, strict=True)]

    def sorted(self, values: Sequence[np.ndarray], joint: int) -> np.ndarray:
        """Columns of i candidates on a joint, (p, r) each, sorted, shape (i, p, r)."""
        order, weight = self.blocks.order, self.weight[joint]
        return np.stack([column[:, order] for column in values]) * weight

    def sums(self, values: np.ndarray) -> np.ndarray:
        """Sums of sorted values (..., r) over the rows of each block, shape (k, ...)."""
        return np.moveaxis(np.add.reduceat(values, self.blocks.starts, axis=-1), -1, 0)

    def by_row(self, values: np.ndarray) -> np.ndarray:
        """Values (k, ...) of each block at its sorted rows, shape (r, ...)."""
        return np.asarray(values[self.blocks.number[self.blocks.order]])

    def in_sequence(self, values: np.ndarray) -> np.ndarray:
        """Sorted values (n, r) as rows in the order of the runs, (r, n)."""
        rows = np.empty((values.shape[1], values.shape[0]))
        rows[self.blocks.order] = values.T
        return rows

    def mixed(self, torque: np.ndarray, count: int) -> np.ndarray:
        """Products of the columns of all unknowns with another torque (r, n), shape (b,)."""
        products, torque = np.zeros(count), torque[self.blocks.order]
        for joint, (columns, acting) in enumerate(zip(self.columns, self.acting, strict=True)):
            products[acting] += torque[:, joint] @ columns
        return products

    def residual(self, values: np.ndarray) -> np.ndarray:
        """Residual of the torque with unknowns (b,), or (k, b) if each block has its own, shape (n, r)."""
        return self.torque - self.torque_of([values[..., acting] for acting in self.acting])

    def torque_of(self, values: Sequence[np.ndarray]) -> np.ndarray:
        """Torque of each joint's unknowns, [n] of (a,), or (k, a) if each block has its own, shape (n, r)."""
        torque = np.empty(self.torque.shape)
        for joint, (columns, unknowns) in enumerate(zip(self.columns, values, strict=True)):
            by_block = np.broadcast_to(unknowns, (len(self.spans), unknowns.shape[-1]))
            for rows, block in zip(self.spans, by_block, strict=True):
                torque[joint, rows] = columns[rows] @ block
        return torque

    def errors(self, values: np.ndarray) -> np.ndarray:
        """Squared residual of each block with its own set of unknowns (k, b), shape (k, n) [(N m)^2]."""
        return self.sums(np.square(self.residual(values)))
