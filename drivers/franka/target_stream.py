"""Target stream: commands held back for a while and given out one each millisecond, or a stop.

The controller takes a stream without holes only: a command that is missing or comes twice is a jump of its
velocity. What the loop's computer is late by is taken from those that are held back.
"""

from collections import deque
from typing import NamedTuple

import numpy as np

from .fci_limits import CYCLE, LimitCheck
from .stop_profile import stopping


class Step(NamedTuple):
    """What the controller is given next.

    Attributes:
        position: Shape (n,) [rad].
        finished: Whether that is the end.
    """

    position: np.ndarray
    finished: bool


class TargetStream:
    """One motion, from rest to rest.

    Args:
        start: Where the controller holds the arm, shape (n,) [rad].
        held_back: Commands that wait before the first is given out.

    Attributes:
        reason: Why it stops; empty while it does not.
    """

    def __init__(self, start: np.ndarray, held_back: int) -> None:
        self._waiting, self._held_back, self._begun = deque[np.ndarray](), held_back, False
        self._check = LimitCheck(start)
        self._stop: np.ndarray | None = None
        self._row = 0
        self.reason = ""

    def add(self, position: np.ndarray) -> None:
        """A command, shape (n,) [rad]; after a stop has begun it does not count."""
        self._waiting.append(position)

    def stop(self, reason: str) -> None:
        """From the next step on, come to rest."""
        if self._stop is None:
            self.reason = reason
            check = self._check
            self._stop = stopping(check.position, check.velocity, check.acceleration)

    def next(self, cycles: int) -> Step:
        """What belongs to now, so many cycles after the last step; those between are left out."""
        for _ in range(cycles):
            self._advance()
        if self._stop is None:
            return Step(self._check.position, False)
        row = min(self._row, len(self._stop)) - 1
        return Step(self._stop[max(row, 0)], row + 1 >= len(self._stop))

    def _advance(self) -> None:
        if self._stop is None:
            self._follow()
        if self._stop is not None:
            self._row += 1

    def _follow(self) -> None:
        """Take the next command, or begin a stop."""
        self._begun = self._begun or len(self._waiting) >= self._held_back
        if not self._begun:
            return
        if not self._waiting:
            self.stop(
                f"no command for {1e3 * self._held_back * CYCLE:.0f} ms: the arm was stopped. Is this "
                "computer busy? Try a larger `buffer`"
            )
        elif wrong := self._check.look(self._waiting.popleft()):
            self.stop(f"{wrong}: the arm was stopped. Plan the motion within the limits of the FCI")
