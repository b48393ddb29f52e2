"""The host's clock: ticks at absolute deadlines, and what time it is."""

import time
from typing import NamedTuple

WALL = time.time_ns() - time.monotonic_ns()
"""Read once, so that host times never go back when the clock is set [ns]."""


def host_time() -> int:
    """Now [ns since 1970], from the monotonic clock."""
    return time.monotonic_ns() + WALL


class Tick(NamedTuple):
    """One tick of the clock.

    Attributes:
        number: Of the tick, from zero.
        lateness: Time from the deadline that was waited for to now [s].
        skipped: Deadlines that had gone by when this one was reached.
    """

    number: int
    lateness: float
    skipped: int


class HostClock:
    """Ticks at start + k cycles. After a late one the missed are skipped, never run after in a burst.

    Args:
        cycle: Time between ticks [s].
    """

    def __init__(self, cycle: float) -> None:
        self._cycle = round(cycle * 1e9)
        self._deadline = 0
        self._number = -1

    def wait(self) -> Tick:
        """Sleep until the next deadline; the first is one cycle after the first call."""
        now = time.monotonic_ns()
        if not self._deadline:
            self._deadline = now
        self._deadline += self._cycle
        if now < self._deadline:
            time.sleep((self._deadline - now) * 1e-9)
        late = time.monotonic_ns() - self._deadline
        skipped = max(late, 0) // self._cycle
        self._deadline += skipped * self._cycle
        self._number += 1 + skipped
        return Tick(self._number, late * 1e-9, skipped)

    @property
    def left(self) -> float:
        """Time until the next deadline [s]; negative when it is over."""
        return (self._deadline + self._cycle - time.monotonic_ns()) * 1e-9
