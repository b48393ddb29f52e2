"""Linkage: which axis moves when which axis is corrected.

Every axis is corrected in two patterns, and no two axes share both. An axis that moves in the patterns of
another axis follows that axis' corrections, for example because an output of the ETHERNET object is linked to
the wrong input of AXISCORR. An axis that moves in more than two patterns follows several axes.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

MOVED = 0.4
"""Fraction of a correction above which an axis has moved [-]: an arm that begins to follow while the first
pattern of the probe rises still moves by the full correction when the pattern falls."""
OVERSHOOT = 0.8
"""Fraction by which a motion may exceed its correction [-]: a drive that must first overcome friction
overshoots by up to 0.6, plus noise; an axis that follows a second correction exceeds its own by 1."""


def pattern_table(axes: int) -> np.ndarray:
    """Patterns of corrections, shape (p, n): 1 in the two patterns of each axis, else 0."""
    count = next(count for count in itertools.count(2) if math.comb(count, 2) >= axes)
    table = np.zeros((count, axes))
    for axis, pair in enumerate(itertools.islice(itertools.combinations(range(count), 2), axes)):
        table[pair, axis] = 1.0
    return table


@dataclass(frozen=True)
class Linkage:
    """Motions of all axes in all patterns."""

    axes: Sequence[str]  # names of the axes
    corrections: np.ndarray  # corrections, zero for an axis that is not corrected, shape (p, n) [deg]
    motions: np.ndarray  # measured motions, shape (p, n) [deg]
    size: float  # magnitude of the corrections [deg]

    @property
    def agrees(self) -> bool:
        """Whether every axis followed its corrections and no others."""
        return not self._wrong.any()

    @property
    def stuck(self) -> bool:
        """Whether the only fault is that corrected axes did not move, which friction may explain."""
        still = (self.corrections != 0.0) & (np.abs(self.motions) <= MOVED * self.size)
        return bool(still[self._wrong].all())

    @property
    def followed(self) -> np.ndarray:
        """Motions of corrected axes in the direction of their corrections, shape (k,) [deg]."""
        corrected = self.corrections != 0.0
        return (np.sign(self.corrections) * self.motions)[corrected]

    def refusal(self) -> str:
        """Which axes did not move as corrected, and what to do about it."""
        faulty = np.flatnonzero(self._wrong.any(axis=0)).tolist()
        sources = {axis: self._source(axis) for axis in faulty}
        crossed = [
            f"{self.axes[axis]} moved when {self.axes[source]} was corrected"
            for axis, source in sources.items()
            if source is not None
        ]
        if crossed:
            return (
                f"corrections reach the wrong axes: {', '.join(crossed)}. Link the ETHERNET object's outputs "
                "to the inputs of AXISCORR axis by axis"
            )
        return (
            f"corrections of {self.size:g} degrees did not move the arm by this amount: "
            f"{', '.join(map(self._worst, faulty))}. Are the drives on and RSI_MOVECORR called? Are the "
            "ETHERNET object's outputs linked to AXISCORR, axis by axis? A STOP object may keep corrections "
            "from having an effect"
        )

    @property
    def _wrong(self) -> np.ndarray:
        """Whether an axis did not move as corrected in a pattern, shape (p, n)."""
        return ~self._alike(self.motions, self.corrections)

    def _alike(self, motions: np.ndarray, corrections: np.ndarray) -> np.ndarray:
        beyond = np.sign(corrections) * (motions - corrections) > 0.0
        share = np.where(corrections == 0.0, MOVED, np.where(beyond, OVERSHOOT, 1.0 - MOVED))
        return np.asarray(np.abs(motions - corrections) <= share * self.size)

    def _source(self, axis: int) -> int | None:
        """Axis whose corrections this axis follows, with either sign, possibly in addition to its own."""
        motions = self.motions[:, axis]
        for source, corrections in enumerate(self.corrections.T):
            if source == axis or not corrections.any():
                continue
            for extra in (motions, motions - self.corrections[:, axis]):
                if self._alike(extra, corrections).all() or self._alike(extra, -corrections).all():
                    return source
        return None

    def _worst(self, axis: int) -> str:
        """Name of an axis, with its motion and correction in the pattern where they differ most."""
        pattern = int(np.abs(self.motions[:, axis] - self.corrections[:, axis]).argmax())
        motion, correction = self.motions[pattern, axis], self.corrections[pattern, axis]
        return f"{self.axes[axis]} ({motion:.2g} instead of {correction:.2g})"
