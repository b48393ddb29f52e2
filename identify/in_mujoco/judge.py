"""Whether a simulation is nearer to the recordings than another, at the tool point or at the joints."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from .distances import Distances

SURE = 1.64
"""Number of standard errors by which a mean has changed with 95 % confidence (one-sided)."""
MATERIAL = 0.05
"""Share of the rms error below which a change makes no difference in practice."""
ON_AXIS = 1e-9
"""Distance of tool points that is only rounding [m]."""
TOOL, JOINTS = "tool", "joints"
"""What a simulation is judged by."""


class Gain(Enum):
    """Change of a simulation relative to the recordings."""

    BETTER = "better"
    SAME = "same"
    WORSE = "worse"


@dataclass(frozen=True)
class Judge:
    """Comparison of simulations."""

    by: str = TOOL  # `TOOL` or `JOINTS`; the joints also judge if the tool point lies on all of their axes

    def compared(self, first: Distances, second: Distances) -> Gain:
        """Whether the second simulation is nearer to the recordings than the first.

        It is nearer, or farther, if its mean squared error over all starts has changed with 95 % confidence,
        and its rms error by more than `MATERIAL`.
        """
        before, after = self._squares(first, first), self._squares(second, first)
        diverged = [not np.all(np.isfinite(squares)) for squares in (before, after)]
        if any(diverged):
            return {(1, 1): Gain.SAME, (1, 0): Gain.BETTER, (0, 1): Gain.WORSE}[
                int(diverged[0]), int(diverged[1])
            ]
        growth = after - before
        spread = float(np.std(growth)) / np.sqrt(len(growth))
        ratio = np.sqrt(float(np.mean(after)) / max(float(np.mean(before)), np.finfo(float).tiny))
        if abs(float(np.mean(growth))) <= SURE * spread or abs(ratio - 1.0) < MATERIAL:
            return Gain.SAME
        return Gain.BETTER if ratio < 1.0 else Gain.WORSE

    def _squares(self, distances: Distances, reference: Distances) -> np.ndarray:
        """Mean squared error of each start, relative to that of the reference, shape (w,)."""
        if self.by == TOOL and np.any(reference.tools > ON_AXIS):
            return np.asarray(np.mean((distances.tools / _rms(reference.tools)) ** 2, axis=1))
        joints = np.arange(distances.ends.shape[2])
        errors, scale = (of.ends[:, reference.telling, joints] for of in (distances, reference))
        return np.asarray(np.mean((errors / _rms(scale)) ** 2, axis=1))


def _rms(errors: np.ndarray) -> np.ndarray:
    """Rms of errors (w, k) over the starts, shape (k,); 1 where it is zero or infinite."""
    with np.errstate(over="ignore", invalid="ignore"):
        rms = np.sqrt(np.mean(errors**2, axis=0))
    return np.where(np.isfinite(rms) & (rms > 0.0), rms, 1.0)
