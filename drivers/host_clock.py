"""The host's clock: ticks at absolute deadlines, what time it is, and how long answers usually take."""

import time
from typing import NamedTuple

WALL = time.time_ns() - time.monotonic_ns()
"""Read once, so that host times never go back when the clock is set [ns]."""


def host_time() -> int:
    """Now [ns since 1970], from the monotonic clock."""
    return time.monotonic_ns() + WALL


class Tick(NamedTuple):
    """One tick of the clock: its number from zero, and how late it is [s].

    `skipped` deadlines had gone by when this one was reached.
    """

    number: int
    lateness: float
    skipped: int


class HostClock:
    """Ticks at start + k cycles [s]. After a late one the missed are skipped, never run after in a burst."""

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


LONGER, SHORTER = 20e-6, 2e-6
"""By how much the next sleep is longer where an answer had to be waited for after it, and shorter where none
had to [s]: in balance, one cycle in eleven waits again."""
SHORTEST = 50e-6
"""Below this a sleep is left out: it would take longer than it was asked for [s]."""


class AnswerTime:
    """The usual time between a question and the last of its answers."""

    def __init__(self) -> None:
        self._usual = 0.0

    def sleep(self) -> None:
        """Right after the question: sleep until its answers have usually come."""
        if self._usual >= SHORTEST:
            time.sleep(self._usual)

    def adjust(self, waited: bool) -> None:
        """All answers have come; whether they had to be waited for after the sleep."""
        self._usual = max(self._usual + (LONGER if waited else -SHORTER), 0.0)
