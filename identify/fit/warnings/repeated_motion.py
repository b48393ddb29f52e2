"""A run held out that repeats a fitted motion: the model is not asked for anything new."""

from collections.abc import Sequence

import numpy as np

from ...preparation.prepare import Prepared

ALIKE = 0.02
"""Difference of two motions over their size below which one repeats the other [-]: controllers repeat to
better than a hundredth, and other motions differ by as much as they move."""
APART = 10.0
"""Time by which one recording may begin later in the motion than the other [s]."""
COARSE, FINE = 0.05, 0.001
"""Between the shifts that are tried, of all and around the best of these [s]."""
NEAR = 0.5
"""Difference at the best coarse shift below which the fine ones are tried [-]."""
OVERLAP = 0.5
"""Share of the shorter run that the other has to cover."""


def repeated_motions(used: Sequence[Prepared], held_out: Sequence[Prepared]) -> list[str]:
    """A warning for each run held out with the motion of a fitted one that carries the same.

    Args:
        used: Runs that are fitted.
        held_out: Runs that are only predicted.
    """
    return [
        f"{run.name} repeats the motion of {other.name}: that it is predicted shows that the arm repeats, "
        "not that the model is right elsewhere. Hold out another motion"
        for run in held_out
        for other in used
        if run.motion.payload == other.motion.payload and _difference(run, other) < ALIKE
    ]


def _difference(one: Prepared, other: Prepared) -> float:
    """Root mean square between two motions over their size, at the shift at which it is least [-]."""
    first, second = _even(one, 0.0), _even(other, 0.0)
    reach = round(APART / COARSE)
    coarse = {shift: _apart(first, second, shift) for shift in range(-reach, reach + 1)}
    best = min(coarse, key=lambda shift: coarse[shift])
    if not coarse[best] < NEAR:
        return coarse[best]
    later = np.arange(-COARSE, COARSE, FINE)
    return min(_apart(first, _even(other, float(by)), best) for by in later)


def _even(run: Prepared, later: float) -> np.ndarray:
    """Positions (t, n) every `COARSE`, of so much later [s]."""
    time = run.motion.time - run.motion.time[0]
    at = np.arange(0.0, time[-1], COARSE) + later
    return np.column_stack([np.interp(at, time, joint) for joint in run.motion.position.T])


def _apart(first: np.ndarray, second: np.ndarray, shift: int) -> float:
    """The same of rows (t, n), the second begun so many rows later; infinite where they share too few."""
    here, there = first[max(shift, 0) :], second[max(-shift, 0) :]
    rows = min(len(here), len(there))
    if rows < max(OVERLAP * min(len(first), len(second)), 2):
        return np.inf
    here, there = here[:rows], there[:rows]
    size = float(np.linalg.norm(here - here.mean(axis=0)))
    return float(np.linalg.norm(here - there)) / max(size, 1e-12)
