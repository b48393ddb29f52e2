"""Stamps that are times of arrival, and the regular clocks that replace them."""

import numpy as np
import pytest

from exidyn.identification.recordings.arrival_times import regular_clock

PERIOD = 0.01


def positions(time):
    """Two joints in motion, with the noise of encoders."""
    noise = 2e-5 * np.random.default_rng(1).normal(size=(len(time), 2))
    return np.stack([np.sin(1.7 * time), 0.5 * np.cos(2.9 * time)], axis=1) + noise


def samples(lost=()):
    """Times of samples, some of which are lost."""
    return np.delete(PERIOD * np.arange(1500), list(lost))


def in_bursts(time, count):
    last = (np.floor(time / (count * PERIOD) + 1e-6) + 1) * count * PERIOD
    return last + 2e-5 * np.arange(len(time)) % 1e-3


def late(time, seconds):
    return np.maximum.accumulate(time + np.random.default_rng(2).exponential(seconds, len(time)))


def rounded(time, step):
    return np.floor(time / step + 1e-6) * step


@pytest.mark.parametrize(
    ("stamps", "kind"),
    [
        (lambda time: in_bursts(time, 2), "bursts"),
        (lambda time: in_bursts(time, 20), "bursts"),
        (lambda time: late(time, 0.004), "late"),
        (lambda time: 1.7e9 + 1.0001 * late(time, 0.01), "late"),
        (lambda time: rounded(time, 0.1), "rounded to 100 ms"),
    ],
)
@pytest.mark.parametrize("lost", [(), (400,), range(700, 740)])
def test_a_regular_clock_replaces_times_of_arrival(stamps, kind, lost):
    time = samples(lost)
    clock = regular_clock(stamps(time), positions(time))
    assert clock is not None
    assert clock.certain
    assert kind in clock.kind
    assert clock.missing == len(lost)
    off = clock.time - time
    drift = np.polynomial.Polynomial.fit(time, off, 1)
    assert np.abs(off - drift(time)).max() < 0.02 * PERIOD
    [fact] = clock.facts(stamps(time))
    assert "A regular clock of" in fact


@pytest.mark.parametrize("lost", [(), range(700, 740), range(0, 1500, 3)])
def test_true_stamps_stay(lost):
    time = samples(lost)
    assert regular_clock(time, positions(time)) is None
    jitter = np.sort(time + np.random.default_rng(3).uniform(0.0, 0.004, len(time)))
    assert regular_clock(jitter, positions(jitter)) is None


def test_a_clock_that_is_unclear_is_kept_and_said():
    time = samples()
    assert regular_clock(late(time, 0.004), 0.0 * positions(time)) is None
    time = samples()
    stamps = late(time, 0.004)
    clock = regular_clock(stamps, positions(0.5 * (time + stamps)))
    assert clock is not None
    assert not clock.certain
    assert "they are kept" in next(clock.facts(stamps))


@pytest.mark.parametrize("seconds", [0.37, -0.37])
def test_a_clock_that_was_set_in_motion_is_set_back(seconds):
    time = samples()
    stamps = time + seconds * (time > 7.0)
    clock = regular_clock(stamps, positions(time))
    assert clock is not None
    assert clock.certain
    np.testing.assert_allclose(clock.time, time, atol=1e-6)
    assert f"set by {seconds:+.3f} s at 7.000 s" in next(clock.facts(stamps))
