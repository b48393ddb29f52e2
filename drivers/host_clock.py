"""Clock of the host: ticks at absolute deadlines, time stamps, pauses, and the usual time to an answer."""

import select
import time
from collections.abc import Sequence
from threading import Thread
from typing import NamedTuple

from .errors import BadSettings

WALL = time.time_ns() - time.monotonic_ns()
"""Offset of the monotonic clock [ns], read once so that host times never go back when the clock is set."""


BOOT_CLOCK = getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC)
"""Clock of Linux that also counts while a laptop is suspended."""


class Clock:
    """The clock by which drivers measure time, sleep, and wait for files and threads; here that of the host.

    A simulation may replace it in `Driver.clock`.
    """

    monotonic = staticmethod(time.monotonic)
    monotonic_ns = staticmethod(time.monotonic_ns)
    sleep = staticmethod(time.sleep)

    def host_time(self) -> int:
        """Current time [ns since 1970], from the monotonic clock."""
        return self.monotonic_ns() + WALL

    def uptime_ns(self) -> int:
        """Time since the host was started, suspended or not [ns]."""
        return time.clock_gettime_ns(BOOT_CLOCK)

    def age(self, arrival: int) -> int:
        """Time since the kernel received something at its wall clock's `arrival` [ns]."""
        return time.time_ns() - arrival

    def readable(self, files: Sequence[int], timeout: float) -> bool:
        """Wait until one of the files can be read, at most `timeout` [s]; returns whether one can."""
        return bool(select.select(files, [], [], timeout)[0])

    def writable(self, files: Sequence[int], timeout: float) -> bool:
        """Wait until one of the files can be written, at most `timeout` [s]; returns whether one can."""
        return bool(select.select([], files, [], timeout)[1])

    def start(self, thread: Thread) -> None:
        """Start a thread that uses this clock."""
        thread.start()

    def join(self, thread: Thread) -> None:
        """Wait until such a thread has ended."""
        thread.join()


HOST = Clock()


class Tick(NamedTuple):
    """One tick of the clock: its number from zero, its lateness [s], and how many deadlines it skipped."""

    number: int
    lateness: float
    skipped: int


class HostClock:
    """Ticks at start + k cycles. Deadlines missed by a late tick are skipped, never made up in a burst."""

    def __init__(self, cycle: float, clock: Clock = HOST) -> None:
        self._cycle, self._clock = round(cycle * 1e9), clock
        self._deadline = 0
        self._number = -1

    def wait(self) -> Tick:
        """Sleep until the next deadline; the first is one cycle after the first call."""
        now = self._clock.monotonic_ns()
        if not self._deadline:
            self._deadline = now
        self._deadline += self._cycle
        if now < self._deadline:
            self._clock.sleep((self._deadline - now) * 1e-9)
        late = self._clock.monotonic_ns() - self._deadline
        skipped = max(late, 0) // self._cycle
        self._deadline += skipped * self._cycle
        self._number += 1 + skipped
        return Tick(self._number, late * 1e-9, skipped)


EARLY = 0.8
"""Fraction of the drives' patience after which a pause counts [-]: drives may have received the last frame
some time before the pause, for example a heartbeat, which is sent eight times per patience."""


class Pause:
    """Detects that the host has sent nothing for so long that drives stop by themselves.

    The host was paused, suspended or too busy. The next command could switch the drives on again. `patience`
    is the silence after which they stop [s].
    """

    def __init__(self, patience: float, clock: Clock = HOST) -> None:
        self._clock, self.patience = clock, patience
        self.count = 0  # number of such pauses
        self.seconds = 0.0  # duration of the first pause [s]; 0.0 without pauses
        self._limit, self._last = EARLY * patience * 1e9, 0

    def begin(self) -> None:
        """Start measuring; earlier pauses do not count."""
        self.count, self.seconds, self._last = 0, 0.0, self._clock.uptime_ns()

    def noticed(self) -> bool:
        """Whether sending is forbidden now because the silence before it was too long.

        Call this right before sending. It is true only once after a pause, so that a stop can be sent next.
        """
        now = self._clock.uptime_ns()
        silent, self._last = now - self._last, now
        if silent <= self._limit or silent == now:
            return False
        self.count, self.seconds = self.count + 1, self.seconds or 1e-9 * silent
        return True

    def text(self) -> str:
        """Description of the pause, as a fault."""
        return (
            f"this computer sent nothing for {self.seconds:.2f} s, and drives stop by themselves after "
            f"{self.patience:g} s: they are not switched on again, and commands have ended"
        )


def require_patience(setting: str, patience: float, cycle: float, fewest: int) -> None:
    """Raise BadSettings if the patience of drives [s] is shorter than `fewest` cycles [s]."""
    if patience < fewest * cycle:
        raise BadSettings(
            f"{setting} is {patience:g} s, less than {fewest} cycles of {cycle:g} s: a late cycle would "
            f"stop the drives. Try {setting} = {fewest * cycle:g} or more"
        )


LONGER, SHORTER = 20e-6, 2e-6
"""Increase of the next sleep if an answer came after the sleep, and decrease if all came before its end [s]:
in balance, one cycle in eleven waits again."""
SHORTEST = 50e-6
"""Shortest sleep [s]; a shorter one is skipped because it would take longer than requested."""


class AnswerTime:
    """The usual time between a question and the last of its answers."""

    def __init__(self, clock: Clock = HOST) -> None:
        self._usual, self._clock = 0.0, clock

    def sleep(self) -> None:
        """Sleep until the answers have usually arrived. Call this right after the question."""
        if self._usual >= SHORTEST:
            self._clock.sleep(self._usual)

    def adjust(self, waited: bool) -> None:
        """Adjust the sleep once all answers are there; `waited` if some arrived after the sleep."""
        self._usual = max(self._usual + (LONGER if waited else -SHORTER), 0.0)
