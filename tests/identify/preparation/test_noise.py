import numpy as np
import pytest
from scipy import signal

from exidyn.identification.preparation.filters import Decimation
from exidyn.identification.preparation.spectra import (
    noise_above,
    noise_at_rest,
    smoothed,
)

from ...parts.small.two_joints import coloured

pytestmark = pytest.mark.numerical


def filtered_std(noise, decimation):
    """What the filter leaves of a long stretch of noise."""
    return np.std(decimation.apply(noise), axis=0)


@pytest.mark.parametrize("cutoff", [5.0, 20.0, 80.0])
def test_noise_at_rest_is_what_the_filter_leaves(cutoff):
    decimation = Decimation.at(500.0, cutoff)
    noise = np.random.default_rng(3).normal(size=(200_000, 2)) * [0.3, 2.0]
    still = np.zeros(len(noise), bool)
    for start in range(0, len(still), 2000):
        still[start + 300 : start + 1300] = True
    moving = np.where(still[:, None], 0.0, 50.0) + 7.0
    found = noise_at_rest(noise + moving, still, decimation)
    np.testing.assert_allclose(found, filtered_std(noise, decimation), rtol=0.05)


def test_noise_at_rest_has_colour_and_creep_is_none():
    decimation = Decimation.at(500.0, 20.0)
    noise = coloured(60_000, np.random.default_rng(4))
    still = np.arange(len(noise)) % 3000 < 2000
    np.testing.assert_allclose(
        noise_at_rest(noise, still, decimation), filtered_std(noise, decimation), rtol=0.1
    )
    decimation = Decimation.at(500.0, 20.0)
    noise = np.random.default_rng(5).normal(size=(4000, 1))
    creep = np.linspace(0, 100, 4000)[:, None]
    still = np.arange(4000) > 500  # rest after a motion
    plain = noise_at_rest(noise, still, decimation)
    np.testing.assert_allclose(noise_at_rest(noise + creep, still, decimation), plain, rtol=1e-6)
    decimation = Decimation.at(500.0, 20.0)
    still = np.zeros(4000, bool)
    assert np.isnan(noise_at_rest(np.ones((4000, 2)), still, decimation)).all()
    still[::2] = True  # never long enough
    assert np.isnan(noise_at_rest(np.ones((4000, 2)), still, decimation)).all()


def test_rest_before_the_motion_is_preferred_to_the_creep_after():
    decimation = Decimation.at(500.0, 20.0)
    noise = np.random.default_rng(6).normal(size=(4000, 1))
    rows = np.arange(4000)
    first = rows < 1500
    alone = noise_at_rest(noise, first, decimation)
    disturbed = np.where(rows[:, None] > 3000, 10.0 * noise, noise)
    np.testing.assert_allclose(noise_at_rest(disturbed, first | (rows > 2500), decimation), alone, rtol=1e-12)


def test_white_noise_above_the_cutoff_shows_that_below():
    decimation = Decimation.at(500.0, 20.0)
    random = np.random.default_rng(6)
    time = np.arange(20_000) / 500.0
    noise = 0.2 * random.normal(size=(20_000, 1))
    motion = 30.0 * np.sin(2 * np.pi * 0.7 * time)[:, None] + 100.0
    np.testing.assert_allclose(
        noise_above(noise + motion, decimation), filtered_std(noise, decimation), rtol=0.05
    )
    assert np.isnan(noise_above(np.ones((100, 2)), Decimation.at(100.0, 50.0))).all()


RATE = 500.0


def current(seed=7, colour=0.0):
    """A motion's current with noise, white or remembered by `colour`, in steps of a converter."""
    random, time = np.random.default_rng(seed), np.arange(20_000) / RATE
    noise = signal.lfilter([0.2], [1.0, -colour], random.normal(size=(20_000, 2)), axis=0)
    motion = 30.0 * np.sin(2 * np.pi * 0.7 * time) + 5.0 * np.sign(np.cos(2 * np.pi * 0.7 * time))
    return np.round((noise + motion[:, None]) / 0.01) * 0.01


@pytest.mark.parametrize("colour", [0.0, 0.9])
def test_a_current_as_it_was_measured_is_not_taken_for_smoothed(colour):
    assert not smoothed(current(colour=colour), RATE)


@pytest.mark.parametrize("cutoff", [10.0, 40.0, 100.0])
@pytest.mark.parametrize("order", [2, 4])
@pytest.mark.parametrize("passes", [1, 2])
def test_a_current_that_was_low_passed_is_recognised(cutoff, order, passes):
    sections = signal.butter(order, cutoff, fs=RATE, output="sos")
    low_passed = signal.sosfilt if passes == 1 else signal.sosfiltfilt
    assert smoothed(low_passed(sections, current(), axis=0), RATE)
