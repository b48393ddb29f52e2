"""Torque off: stretches in which a drive gave nothing though its joint moved, as of a pendulum let go."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .prepare import Prepared

LEAST = 0.2
"""Length [s] of a stretch of currents that are zero to the last digit: a drive that moves passes through."""
MOVED = 0.02
"""Share of a joint's range in a run that it moves in such a stretch; at rest, nothing need flow."""


def torque_off(current: np.ndarray, position: np.ndarray, rate: float) -> np.ndarray:
    """Whether a drive was off while its joint moved, bool of shape (t, n).

    Args:
        current: Or torque, shape (t, n), unfiltered.
        position: Shape (t, n) [rad].
        rate: Samples a second [Hz].
    """
    off = np.zeros(current.shape, bool)
    whole = np.ptp(position, axis=0)
    for joint in range(current.shape[1]):
        zero = (current[:, joint] == 0.0).astype(int)
        edges = np.flatnonzero(np.diff(zero, prepend=0, append=0))
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            moved = np.ptp(position[start:stop, joint])
            off[start:stop, joint] = stop - start >= LEAST * rate and moved > MOVED * whole[joint]
    return off


def torque_off_warnings(joints: Sequence[str], runs: Sequence["Prepared"]) -> Iterator[str]:
    """What was left out of runs for it, in sentences."""
    for run in runs:
        for joint, seconds in zip(joints, run.off, strict=True):
            if seconds > 0.0:
                yield (
                    f"{run.name}: the {run.measures} of {joint} is exactly zero in {seconds:.1f} s in which "
                    "it moves: its drive was off, or measures none that small; those samples are left out"
                )
