"""Drift: slow motion in one direction, and residual speed; Standstill: whether the arm stands at the end.

Averages over 50 ms suppress noise and encoder steps. Three quarters of a second distinguish joints that creep
from those that swing around their commanded position.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from exidyn.drivers.values import any_of

MEAN = 0.05
"""Averaging window of positions [s]."""
PIECE = 0.25
"""Duration of a piece [s]. A joint that moves in one direction in all pieces has not turned back for more
than half a period at 1 Hz, and no drive's position loop is slower than that."""
PIECES = 3
"""Number of pieces in which a joint must move in the same direction."""
RESTING = 0.01
"""Speed below which a joint is at rest [rad/s]: half a degree per second, or seven standard deviations of the
speed that a coarse encoder (1.5 mrad) at 125 Hz shows over half a second at rest."""
AT_END = 0.5
"""Duration of the straight line whose slope is this speed [s]."""
EMERGENCY = "PRESS THE EMERGENCY STOP"


class Drift:
    """Slow motion of the joints over the last second.

    Args:
        joints: Number of joints n.
        cycle: Sampling period [s].
        flange: Function that returns the flange position, shape (3,) [m], from joint positions (n,), or None.
    """

    def __init__(
        self, joints: int, cycle: float, flange: Callable[[np.ndarray], np.ndarray] | None = None
    ) -> None:
        self._flange = flange
        self._mean = max(round(MEAN / cycle), 1)
        self._piece = max(round(PIECE / cycle), 1)
        self._end = max(round(AT_END / cycle), 3)
        size = max(PIECES * self._piece + self._mean, self._end)
        self._time, self._position = np.zeros(2 * size), np.zeros((2 * size, joints))
        self._size, self._count, self._next = size, 0, 0
        self._silent, self._all_heard = np.zeros(joints), True
        self._known = np.full(joints, np.nan)

    def add(self, time: float, position: np.ndarray) -> None:
        """Add a position (n,) [rad] or [m] at the host's time [s]; silent joints (NaN) keep their last."""
        unheard = np.isnan(position)
        if any_of(unheard):
            position = np.where(unheard, self._known, position)
            self._silent, self._all_heard = np.where(unheard, self._silent + 1, 0), False
        elif not self._all_heard:
            self._silent, self._all_heard = np.zeros(len(position)), True
        self._known = position
        # Every row is stored twice, so that the latest rows are always contiguous.
        for row in (self._next, self._next + self._size):
            self._time[row], self._position[row] = time, position
        self._next = (self._next + 1) % self._size
        self._count += 1

    def silent(self, cycles: int) -> np.ndarray:
        """Whether each joint has been silent for this number of cycles, shape (n,)."""
        return (self._silent >= cycles) | np.isnan(self._known)

    def directed(self) -> np.ndarray:
        """Whether each joint has moved in the same direction in all of the last pieces, shape (n,)."""
        if self._count < self._size:
            return np.zeros(len(self._known), bool)
        positions = np.array([self.mean(k * self._piece) for k in range(PIECES + 1)])
        direction = np.sign(np.diff(positions, axis=0))
        return (direction != 0.0).all(axis=0) & (direction == direction[0]).all(axis=0)

    def flange_distance(self, start: np.ndarray, end: np.ndarray) -> float:
        """Distance of the flange between two joint positions (n,) [m]; 0 if unknown."""
        if self._flange is None or np.isnan(start).any() or np.isnan(end).any():
            return 0.0
        return float(np.linalg.norm(self._flange(end) - self._flange(start)))

    def speed(self) -> np.ndarray:
        """Slope of a line fitted to the last positions, shape (n,) [rad/s] or [m/s]; NaN with too few."""
        if self._count < self._end:
            return np.full(len(self._known), np.nan)
        rows = self._rows(0, self._end)
        time = self._time[rows] - self._time[rows].mean()
        slope: np.ndarray = time @ self._position[rows] / max(time @ time, np.finfo(float).tiny)
        return slope

    def mean(self, cycles: int = 0) -> np.ndarray:
        """Averaged position now, or a number of cycles ago, shape (n,) [rad] or [m]."""
        count = min(self._mean, max(self._count - cycles, 1))
        mean: np.ndarray = self._position[self._rows(cycles, count)].mean(axis=0)
        return mean

    def _rows(self, before: int, count: int) -> slice:
        """Slice of `count` rows, the last of them `before` cycles ago."""
        last = self._next + self._size - before
        return slice(last - count, last)


@dataclass(frozen=True)
class Standstill:
    """Whether the arm stands.

    Attributes:
        moving: Whether the arm still moves; None if unknown.
        text: Sentence with joint, speed and what to do.
        joint: Name of the fastest joint, or of the joint furthest from its last command; empty for none.
        speed: Speed of the fastest joint, in `unit`; NaN where unknown.
        unit: "rad/s" or "m/s".
        away: Distance of that joint from its last command [rad] or [m], if it exceeds the limit; else NaN.
    """

    moving: bool | None
    text: str
    joint: str = ""
    speed: float = float("nan")
    unit: str = ""
    away: float = float("nan")

    @property
    def stands(self) -> bool:
        """Whether the arm is known to stand."""
        return self.moving is False

    @property
    def expected(self) -> bool:
        """Whether the arm stands where it was commanded."""
        return self.stands and not self.away > 0.0

    def details(self) -> dict[str, object]:
        """Known fields for JSON and the recording, by name."""
        known = {"joint": self.joint, "speed": self.speed, "unit": self.unit, "away": self.away}
        known = {name: value for name, value in known.items() if value != "" and value == value}
        return {"moving": self.moving, "standstill": self.text, **known}


def unknown_at_end(reason: str) -> Standstill:
    """Standstill of an arm that cannot be observed for some reason."""
    return Standstill(None, f"WHETHER THE ARM STANDS IS NOT KNOWN ({reason}): {EMERGENCY}")
