"""Drift: slow motion in one direction, and the speed that is left; Standstill: whether the arm stands then.

A mean over 50 ms is below what noise and steps of a coarse encoder show in a cycle; three quarters of a
second tell what creeps on from what swings around where it is held.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from exidyn.drivers.values import any_of

MEAN = 0.05
"""Time over which a position is a mean [s]."""
PIECE = 0.25
"""Time of one displacement [s]. What goes the same way in three of them has not turned back for longer than
half a period of a swing at 1 Hz, slower than which no drive's position loop is."""
PIECES = 3
RESTING = 0.01
"""Speed below which a joint rests at the end [rad/s]: half a degree a second, and seven deviations of what
a coarse encoder (1.5 mrad) at 125 Hz makes of rest over half a second."""
AT_END = 0.5
"""Time over which that speed is a straight line's [s]."""
EMERGENCY = "PRESS THE EMERGENCY STOP"


class Drift:
    """Remembers the last second of positions.

    Args:
        joints: Number n.
        cycle: Time between samples [s].
        flange: Where the flange is, shape (3,) [m], at a position (n,); None where that is not known.
    """

    def __init__(
        self, joints: int, cycle: float, flange: Callable[[np.ndarray], np.ndarray] | None = None
    ) -> None:
        self._flange = flange
        self._mean = max(round(MEAN / cycle), 1)
        self._piece = max(round(PIECE / cycle), 1)
        self._end = max(round(AT_END / cycle), 3)
        kept = max(PIECES * self._piece + self._mean, self._end)
        self._time, self._position = np.zeros(2 * kept), np.zeros((2 * kept, joints))
        self._kept, self._count, self._next = kept, 0, 0
        self._silent, self._heard = np.zeros(joints), True
        self._known = np.full(joints, np.nan)

    def add(self, time: float, position: np.ndarray) -> None:
        """Take in a position (n,) [rad] or [m] at the host's time [s]; a joint that is silent (NaN) stays."""
        unheard = np.isnan(position)
        if any_of(unheard):
            position = np.where(unheard, self._known, position)
            self._silent, self._heard = np.where(unheard, self._silent + 1, 0), False
        elif not self._heard:
            self._silent, self._heard = np.zeros(len(position)), True
        self._known = position
        # Every row stands twice, so that the last ones always lie one behind another.
        for row in (self._next, self._next + self._kept):
            self._time[row], self._position[row] = time, position
        self._next = (self._next + 1) % self._kept
        self._count += 1

    def silent(self, cycles: int) -> np.ndarray:
        """Joints that have been silent for so many cycles, shape (n,)."""
        return (self._silent >= cycles) | np.isnan(self._known)

    def directed(self) -> np.ndarray:
        """Joints that have gone one way in all of the last pieces, shape (n,)."""
        if self._count < self._kept:
            return np.zeros(len(self._known), bool)
        places = np.array([self.mean(k * self._piece) for k in range(PIECES + 1)])
        way = np.sign(np.diff(places, axis=0))
        return (way != 0.0).all(axis=0) & (way == way[0]).all(axis=0)

    def flange_way(self, start: np.ndarray, end: np.ndarray) -> float:
        """Distance of the flange between two positions (n,) [m]; 0 where its place is not known."""
        if self._flange is None or np.isnan(start).any() or np.isnan(end).any():
            return 0.0
        return float(np.linalg.norm(self._flange(end) - self._flange(start)))

    def speed(self) -> np.ndarray:
        """Slope of a straight line through the end, shape (n,) [rad/s] or [m/s]; NaN before there is one."""
        if self._count < self._end:
            return np.full(len(self._known), np.nan)
        rows = self._rows(0, self._end)
        time = self._time[rows] - self._time[rows].mean()
        slope: np.ndarray = time @ self._position[rows] / max(time @ time, np.finfo(float).tiny)
        return slope

    def mean(self, cycles: int = 0) -> np.ndarray:
        """Where the joints are, or were so many cycles ago, shape (n,) [rad] or [m]."""
        count = min(self._mean, max(self._count - cycles, 1))
        mean: np.ndarray = self._position[self._rows(cycles, count)].mean(axis=0)
        return mean

    def _rows(self, before: int, count: int) -> slice:
        """So many rows, the last of them so many cycles ago."""
        last = self._next + self._kept - before
        return slice(last - count, last)


@dataclass(frozen=True)
class Standstill:
    """Whether the arm stands.

    Attributes:
        moving: Whether it still moves; None where that is not known.
        text: In a sentence, with joint, speed and what to do.
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
        """For JSON and the recording."""
        known = {"joint": self.joint, "speed": self.speed, "unit": self.unit, "away": self.away}
        known = {name: value for name, value in known.items() if value != "" and value == value}
        return {"moving": self.moving, "standstill": self.text, **known}


def unknown_at_end(why: str) -> Standstill:
    """Of an arm that cannot be seen."""
    return Standstill(None, f"WHETHER THE ARM STANDS IS NOT KNOWN ({why}): {EMERGENCY}")
