"""The mock's own clock: it stands still between exchanges, so that the same run is the same every time."""

import time

from ..host_clock import HostClock, Tick, host_time

EPOCH = 1_767_225_600_000_000_000
"""Where it begins: the year 2026 [ns since 1970]."""


class SteppedClock:
    """A clock like `HostClock` without waiting: as much time goes by as is given.

    Args:
        cycle: Time between ticks [s].
    """

    def __init__(self, cycle: float) -> None:
        self._cycle = round(cycle * 1e9)
        self._now, self._number = 0, -1

    def wait(self) -> Tick:
        """The next deadline; those that have gone by are skipped."""
        due = (self._number + 1) * self._cycle
        late = max(self._now - due, 0)
        skipped = late // self._cycle
        self._number += 1 + skipped
        self._now = max(self._now, due)
        return Tick(self._number, (late - skipped * self._cycle) * 1e-9, skipped)

    def sleep(self, seconds: float) -> None:
        """Let time go by."""
        self._now += round(seconds * 1e9)

    @property
    def host_time(self) -> int:
        """Now [ns since 1970]."""
        return EPOCH + self._now


class RealClock(HostClock):
    """The host's clock, for a mock that keeps to the time on the wall."""

    def sleep(self, seconds: float) -> None:
        """Let time go by."""
        time.sleep(seconds)

    @property
    def host_time(self) -> int:
        """Now [ns since 1970]."""
        return host_time()
