import time

import pytest

from exidyn.drivers.host_clock import HostClock, host_time

pytestmark = pytest.mark.clocked


def test_ticks_are_whole_cycles_apart_however_late_each_is():
    clock = HostClock(0.005)
    numbers, deadlines = [], []
    for _ in range(20):
        tick = clock.wait()
        numbers.append(tick.number)
        deadlines.append(time.monotonic() - tick.lateness + 0.005 * tick.skipped - 0.005 * tick.number)
    assert numbers == sorted(set(numbers))
    assert max(deadlines) - min(deadlines) < 0.0049


def test_after_a_stall_the_missed_ticks_are_counted_and_not_run_after():
    clock = HostClock(0.01)
    first = clock.wait()
    time.sleep(0.055)
    late = clock.wait()
    after = clock.wait()
    assert late.skipped >= 4
    assert late.lateness >= 0.044
    assert late.number == first.number + 1 + late.skipped
    assert after.number == late.number + 1 + after.skipped


def test_host_time_never_goes_back():
    times = [host_time() for _ in range(1000)]
    assert times == sorted(times)
    assert abs(times[0] - time.time_ns()) < 60e9
