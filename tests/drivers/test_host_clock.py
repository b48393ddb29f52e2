import time

import pytest

from exidyn.drivers import host_clock
from exidyn.drivers.host_clock import HostClock, host_time


class VirtualTime:
    """Time in which nothing passes but what is slept, and how late a sleep ends."""

    def __init__(self, lateness_ns):
        self.now, self._lateness = 10**9, iter(lateness_ns)

    def monotonic_ns(self):
        return self.now

    def sleep(self, seconds):
        self.now += round(seconds * 1e9) + next(self._lateness)


@pytest.fixture
def virtual(monkeypatch):
    """Sets the clock of the driver's host; returns the time."""

    def begin(*lateness_ns):
        virtual_time = VirtualTime(lateness_ns)
        monkeypatch.setattr(host_clock, "time", virtual_time)
        return virtual_time

    return begin


def test_ticks_are_whole_cycles_apart_however_late_each_is(virtual):
    lateness = [0, 4_900_000, 100_000, 12_000_000, 0, 0]
    virtual_time, clock = virtual(*lateness), HostClock(0.005)
    begin, ticks = virtual_time.now, []
    for late in lateness:
        ticks.append(clock.wait())
        deadline = begin + 5_000_000 * (ticks[-1].number + 1 - ticks[-1].skipped)
        assert virtual_time.now == deadline + late
        assert ticks[-1].lateness == pytest.approx(1e-9 * late)
    assert [tick.number for tick in ticks] == [0, 1, 2, 5, 6, 7]
    assert [tick.skipped for tick in ticks] == [0, 0, 0, 2, 0, 0]


def test_after_a_stall_the_missed_ticks_are_counted_and_not_run_after(virtual):
    virtual_time, clock = virtual(0, 0), HostClock(0.01)
    assert clock.wait().number == 0
    virtual_time.now += 55_000_000
    late, after = clock.wait(), clock.wait()
    assert (late.number, late.skipped, after.number, after.skipped) == (5, 4, 6, 0)
    assert late.lateness == pytest.approx(0.045)


def test_host_time_never_goes_back():
    times = [host_time() for _ in range(1000)]
    assert times == sorted(times)
    assert abs(times[0] - time.time_ns()) < 60e9
