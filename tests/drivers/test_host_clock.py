import time

import numpy as np
import pytest

from exidyn.drivers.host_clock import HOST, AnswerTime, Clock, HostClock


class VirtualTime(Clock):
    """Time in which nothing passes but what is slept, and how late a sleep ends."""

    def __init__(self, *lateness_ns):
        self.now, self._lateness = 10**9, iter(lateness_ns)

    def monotonic_ns(self):
        return self.now

    def sleep(self, seconds):
        self.now += round(seconds * 1e9) + next(self._lateness)


def test_ticks_are_whole_cycles_apart_however_late_each_is():
    lateness = [0, 4_900_000, 100_000, 12_000_000, 0, 0]
    virtual_time = VirtualTime(*lateness)
    clock, begin, ticks = HostClock(0.005, virtual_time), virtual_time.now, []
    for late in lateness:
        ticks.append(clock.wait())
        deadline = begin + 5_000_000 * (ticks[-1].number + 1 - ticks[-1].skipped)
        assert virtual_time.now == deadline + late
        assert ticks[-1].lateness == pytest.approx(1e-9 * late)
    assert [tick.number for tick in ticks] == [0, 1, 2, 5, 6, 7]
    assert [tick.skipped for tick in ticks] == [0, 0, 0, 2, 0, 0]


def test_after_a_stall_the_missed_ticks_are_counted_and_not_run_after():
    virtual_time = VirtualTime(0, 0)
    clock = HostClock(0.01, virtual_time)
    assert clock.wait().number == 0
    virtual_time.now += 55_000_000
    late, after = clock.wait(), clock.wait()
    assert (late.number, late.skipped, after.number, after.skipped) == (5, 4, 6, 0)
    assert late.lateness == pytest.approx(0.045)


def test_host_time_never_goes_back():
    times = [HOST.host_time() for _ in range(1000)]
    assert times == sorted(times)
    assert abs(times[0] - time.time_ns()) < 60e9


def sleeps(taken):
    """How long is slept in cycles whose answers take so long [s]; the clock is not looked at."""
    clock, slept = Clock(), [0.0]
    clock.sleep = slept.append
    answer_time = AnswerTime(clock)
    for seconds in taken:
        before = len(slept)
        answer_time.sleep()
        answer_time.adjust(waited=seconds > (slept[-1] if len(slept) > before else 0.0))
    return np.array(slept[1:])


def test_the_sleep_becomes_as_long_as_answers_take():
    slept = sleeps(np.full(2000, 5e-4))
    assert slept[-500:].min() > 4.7e-4
    assert slept[-500:].max() < 5.3e-4


def test_most_cycles_wait_only_once_where_the_time_scatters():
    taken = 5e-4 + 3e-5 * np.random.default_rng(0).normal(size=4000)
    slept = sleeps(taken)
    assert np.mean(taken[-2000:] > slept[-2000:]) == pytest.approx(1 / 11, abs=0.03)


def test_one_slow_cycle_changes_little():
    slept = sleeps([*np.full(1000, 3e-4), 2e-3, *np.full(10, 3e-4)])
    assert slept[-1] < 3.3e-4


def test_answers_that_are_there_at_once_are_not_slept_for():
    assert len(sleeps(np.zeros(100))) == 0
