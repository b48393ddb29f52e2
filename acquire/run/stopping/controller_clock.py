"""The controller's clock: whether it keeps time while samples come."""

from collections import deque

from exidyn.drivers import Command, Sample, StopLevel
from exidyn.drivers.values import any_of

from .monitors import Monitor
from .stop import Stop

CLOCK_WINDOW = 2.0
"""Time over which the controller's clock is held against the host's, over the longest stall that is borne
[-]."""
CLOCK_RATE = 0.5
"""Of the host's rate, below which the controller's clock does not keep time [-]: clocks differ by 1e-4, and a
sample that is late by the longest stall makes two thirds of the window."""
CLOCK_CYCLES = 5
"""Cycles in a row after which that is sure."""


class ControllerClock(Monitor):
    """The controller's clock, which goes on while samples come; all times of the recording are by it.

    Args:
        cycle: Time between exchanges [s].
        stall: Longest time without one [s].
    """

    def __init__(self, cycle: float, stall: float) -> None:
        window = max(round(CLOCK_WINDOW * stall / cycle), CLOCK_CYCLES)
        self._times = deque[tuple[int, int]](maxlen=window + 1)
        self._count = 0

    def look(self, sample: Sample, sent: Command | None) -> Stop | None:
        if sample.stale.size and not any_of(~sample.stale):  # nothing came, so no time either
            return None
        self._times.append((sample.host_time, sample.controller_time))
        if len(self._times) < (self._times.maxlen or 0):
            return None
        (began, zero), (now, time) = self._times[0], self._times[-1]
        host, controller = 1e-9 * (now - began), 1e-9 * (time - zero)
        self._count = self._count + 1 if controller < CLOCK_RATE * host else 0
        if self._count < CLOCK_CYCLES:
            return None
        text = (
            f"the controller's clock went on by {controller:.3f} s in {host:.3f} s while samples came: their "
            "times cannot be trusted. Restart the controller"
        )
        return Stop(StopLevel.QUICK, "controller clock", text, "", controller, CLOCK_RATE * host, "s")
