"""Resting: where joints stand before they are powered, known only where several measurements in a row agree.

A drive holds the goal that it has when it is switched on. If that came from one wrong measurement, the drive
would jump there.
"""

from collections import deque
from statistics import median

COUNT = 5
"""Measurements in a row that must agree."""
APART = 0.035
"""How far they may be from each other [rad] or [m]: two degrees, which a drive that is switched on may jump
by, and which an arm held by hand does not move in five cycles."""


class Resting:
    """Where each of n joints stands, by its last measurements [rad] or [m]."""

    def __init__(self, joints: int) -> None:
        self._seen = [deque[float](maxlen=COUNT) for _ in range(joints)]

    def add(self, joint: int, position: float) -> None:
        """Take in a measurement; NaN begins anew."""
        if position == position:
            self._seen[joint].append(position)
        else:
            self._seen[joint].clear()

    def known(self, joint: int) -> bool:
        """Whether enough measurements in a row agree."""
        return len(self._seen[joint]) == COUNT and self.spread(joint) <= APART

    def position(self, joint: int) -> float:
        """Median of the last measurements."""
        return median(self._seen[joint])

    def spread(self, joint: int) -> float:
        """Largest distance between the last measurements; 0.0 for none."""
        seen = self._seen[joint]
        return max(seen) - min(seen) if seen else 0.0

    def doubt(self, joint: int) -> str:
        """Why it is not known where a joint stands, in words."""
        if len(self._seen[joint]) < COUNT:
            return f"it gave {len(self._seen[joint])} positions in a row, {COUNT} are needed"
        return f"its last {COUNT} positions differ by {self.spread(joint):.3g} rad, limit {APART:g}"
