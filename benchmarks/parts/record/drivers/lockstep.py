"""Lockstep: host and peer count cycles instead of looking at the clock, so that a late machine is not seen.

Drivers, wires and peers are the same; only what the clock would add is missing. For figures in which the
timing of the machine is not the question.
"""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from unittest import mock

from exidyn.drivers import host_clock
from exidyn.drivers.can import can_driver
from exidyn.drivers.can_mit import mit_motors
from exidyn.drivers.canopen_402 import frames as canopen_frames
from exidyn.drivers.host_clock import HostClock, Tick
from exidyn.drivers.servo import servo_driver

SLOWER = 3.0
"""Times that a cycle takes longer than it counts: peers answer in time."""


class Counting(HostClock):
    """A clock on which each cycle takes what it should."""

    now = host_clock.host_time()

    def wait(self) -> Tick:
        time.sleep(SLOWER * self._cycle * 1e-9)
        self._number += 1
        Counting.now += self._cycle
        return Tick(self._number, 0.0, 0)


def counted() -> int:
    """Time [ns since 1970] by the number of cycles."""
    return Counting.now


@contextmanager
def lockstep() -> Iterator[None]:
    """Drivers that are made in the block count; their peers need `--lockstep`."""
    with mock.patch.multiple(can_driver, HostClock=Counting, PATIENCE=SLOWER * can_driver.PATIENCE):
        with (
            mock.patch.multiple(servo_driver, HostClock=Counting, host_time=counted),
            mock.patch.object(mit_motors, "host_time", counted),
            mock.patch.object(canopen_frames, "host_time", counted),
        ):
            yield
