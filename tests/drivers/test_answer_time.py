"""AnswerTime: one sleep for all answers of a cycle, about as long as they take."""

import time

import numpy as np
import pytest

from exidyn.drivers.host_clock import AnswerTime


def sleeps(monkeypatch, taken):
    """How long is slept in cycles whose answers take so long [s]; the clock is not looked at."""
    found, answer_time = [0.0], AnswerTime()
    monkeypatch.setattr(time, "sleep", lambda seconds: found.append(seconds))
    for seconds in taken:
        before = len(found)
        answer_time.sleep()
        answer_time.adjust(waited=seconds > (found[-1] if len(found) > before else 0.0))
    return np.array(found[1:])


def test_the_sleep_becomes_as_long_as_answers_take(monkeypatch):
    slept = sleeps(monkeypatch, np.full(2000, 5e-4))
    assert slept[-500:].min() > 4.7e-4
    assert slept[-500:].max() < 5.3e-4


def test_most_cycles_wait_only_once_where_the_time_scatters(monkeypatch):
    taken = 5e-4 + 3e-5 * np.random.default_rng(0).normal(size=4000)
    slept = sleeps(monkeypatch, taken)
    assert np.mean(taken[-2000:] > slept[-2000:]) == pytest.approx(1 / 11, abs=0.03)


def test_one_slow_cycle_changes_little(monkeypatch):
    slept = sleeps(monkeypatch, [*np.full(1000, 3e-4), 2e-3, *np.full(10, 3e-4)])
    assert slept[-1] < 3.3e-4


def test_answers_that_are_there_at_once_are_not_slept_for(monkeypatch):
    assert len(sleeps(monkeypatch, np.zeros(100))) == 0
