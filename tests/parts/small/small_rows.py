"""Rows, blocks and candidates made by hand, for tests of what is asked of them."""

from collections.abc import Sequence

import numpy as np
from scipy import signal

from exidyn.identification.diagnosis.blocks.blocks import Blocks
from exidyn.identification.diagnosis.blocks.prediction import Prediction
from exidyn.identification.diagnosis.questions.candidate import Candidate, Thinned
from exidyn.identification.diagnosis.runs.rows import Rows

RATE = 100.0
"""Of the rows [Hz]."""


def blocks(lengths: Sequence[int], held_out: Sequence[int] = ()) -> Blocks:
    """Blocks of so many rows each; some are only predicted."""
    fitted = np.array([place not in held_out for place in range(len(lengths))])
    return Blocks(
        np.repeat(np.arange(len(lengths)), lengths), fitted, np.arange(sum(lengths)), lengths[0] / RATE
    )


def rows(
    torque: np.ndarray,
    columns: np.ndarray,
    std: np.ndarray,
    mean: np.ndarray | None = None,
    runs: Sequence[int] = (),
    weight: np.ndarray | None = None,
) -> Rows:
    """Rows of a torque (r, n) and columns (r, n, b); the runs start at the given rows."""
    edges = [0, *runs, len(torque)]
    return Rows(
        tuple(slice(a, b) for a, b in zip(edges[:-1], edges[1:], strict=True)),
        torque,
        np.ones_like(torque) if weight is None else weight,
        (columns,),
        tuple(f"x{k}" for k in range(columns.shape[2])),
        std,
        np.zeros(len(std)) if mean is None else mean,
        np.full(len(std), -np.inf),
        np.zeros(len(std), bool),
    )


def predicted(given: Rows, pieces: Blocks) -> Prediction:
    return Prediction.of(given, pieces, RATE)


def asked(
    column: np.ndarray,
    joints: Sequence[int],
    lower: Sequence[float] | None = None,
    mean: Sequence[float] | None = None,
    std: Sequence[float] | None = None,
    **more: object,
) -> tuple[Candidate, Thinned]:
    """A candidate whose columns (r, k, p) act on some joints; expected about a mean where one is given."""
    count = column.shape[2]
    deviations = np.full(count, 1.0) if std is None else np.array(std)
    expected = None if mean is None else tuple(zip(mean, deviations, strict=True))
    candidate = Candidate(
        str(more.pop("effect", "something")),
        tuple(more.pop("where", joints)),  # type: ignore[arg-type]
        lambda run: run,  # type: ignore[arg-type,return-value]
        ("size",) * count,
        ("N m",) * count,
        (-np.inf,) * count if lower is None else tuple(lower),
        rows=tuple(joints),
        expected=expected,
        **more,  # type: ignore[arg-type]
    )
    centre = np.zeros(count) if mean is None else np.array(mean)
    return candidate, Thinned(np.array(joints), column, deviations, centre)


def remembering(random: np.random.Generator, shape: tuple[int, ...], memory: float) -> np.ndarray:
    """Noise of deviation one that remembers for some time [s], along the first axis."""
    if memory == 0.0:
        return random.normal(size=shape)
    keep = float(np.exp(-1.0 / (RATE * memory)))
    lead = int(10 * RATE * memory) + 1
    white = random.normal(size=(shape[0] + lead, *shape[1:]))
    return signal.lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], white, axis=0)[lead:]
