"""Blocks: the runs cut into pieces of some seconds, each of which can be left out and predicted."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..runs.driven import Driven, slices

SECONDS = 2.0
"""Length of a block [s]: several times as long as what is left of a model remembers, a second at most."""
FEWEST, MOST = 16, 24
"""Blocks that all fitted runs are cut into: enough to give scatter to a fifth (16), and no more than give
it to a seventh (24). Short logs have shorter blocks, long ones longer."""
SHORTEST = 0.3
"""Length of the shortest block [s]: five times what the residual of a joint remembers, some 50 ms."""


@dataclass(frozen=True, eq=False)
class Blocks:
    """Pieces of the rows of some runs.

    Attributes:
        number: Block of each row, shape (r,).
        rows: Rows of each block.
        fitted: Whether a block belongs to a run that is fitted, shape (k,); the others are only predicted.
        seconds: Length of a fitted block [s].
    """

    number: np.ndarray
    rows: tuple[slice, ...]
    fitted: np.ndarray
    seconds: float

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
