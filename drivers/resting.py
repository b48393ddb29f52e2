"""Resting positions of joints before power-on, accepted only if several consecutive measurements agree.

A drive holds the goal that it has when it is switched on. If a single wrong measurement set this goal, the
drive would jump there.
"""

from collections import deque
from statistics import median

COUNT = 5
"""Number of consecutive measurements that must agree."""
APART = 0.035
"""Largest difference between them [rad] or [m]: two degrees are an acceptable jump at power-on, and an arm
held by hand moves less in five cycles."""


class Resting:
    """Resting position of each of n joints, from its last measurements [rad] or [m]."""

    def __init__(self, joints: int) -> None:
        self._seen = [deque[float](maxlen=COUNT) for _ in range(joints)]

    def add(self, joint: int, position: float) -> None:
        """Add a measurement; NaN discards the earlier ones."""
        if position == position:
            self._seen[joint].append(position)
        else:
            self._seen[joint].clear()

    def known(self, joint: int) -> bool:
        """Whether enough consecutive measurements agree."""
        return len(self._seen[joint]) == COUNT and self.spread(joint) <= APART

    def position(self, joint: int) -> float:
        """Median of the last measurements."""
        return median(self._seen[joint])

    def spread(self, joint: int) -> float:
        """Largest difference between the last measurements; 0.0 without measurements."""
        seen = self._seen[joint]
        return max(seen) - min(seen) if seen else 0.0

    def doubt(self, joint: int) -> str:
        """Why the position of a joint is not known, in words."""
        if len(self._seen[joint]) < COUNT:
            return f"it gave {len(self._seen[joint])} positions in a row, {COUNT} are needed"
        return f"its last {COUNT} positions differ by {self.spread(joint):.3g} rad, limit {APART:g}"
