"""Fourier series: derivatives, extremes that are the true ones, the same motion shifted or scaled."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.trajectories.errors import BadLimits, OutsideTrajectory
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.trajectory import UNITS


def series(harmonics=5, dof=3, seed=0, period=3.7, periods=1):
    random = np.random.default_rng(seed)
    sine, cosine = random.normal(size=(2, dof, harmonics)) / np.arange(1, harmonics + 1)
    return Fourier(period, random.normal(size=dof), sine, cosine, periods)


def without_highest(one):
    """The same with zeros for the two highest harmonics, and rounding in a third joint's place of them."""
    sine, cosine = one.sine.copy(), one.cosine.copy()
    sine[:, -2:], cosine[:, -2:] = 0.0, 0.0
    sine[-1, -1] = 1e-19
    return replace(one, sine=sine, cosine=cosine)


CASES = {
    "five harmonics": series(),
    "twelve harmonics": series(12, seed=4),
    "highest are zero": without_highest(series()),
    "repeated": series(periods=3),
    "even: sines alone are zero": replace(series(), sine=np.zeros((3, 5))),
}


@pytest.fixture(params=CASES.values(), ids=CASES.keys())
def one(request):
    return request.param


def test_position_is_the_sum_of_waves(one):
    time = np.linspace(0.0, one.duration, 37)
    for joint in range(one.dof):
        expected = np.full(len(time), one.centre[joint])
        for k in range(one.harmonics):
            angle = 2 * np.pi * (k + 1) * time / one.period
            expected += one.sine[joint, k] * np.sin(angle) + one.cosine[joint, k] * np.cos(angle)
        np.testing.assert_allclose(one.at(time).position[:, joint], expected, atol=1e-12)


def test_each_is_the_derivative_of_the_one_before(one):
    step, time = 1e-5, np.linspace(0.1, one.duration - 0.1, 61)
    before, here, after = (one.at(time + side)[1:] for side in (-step, 0.0, step))
    for order in range(3):
        size = np.abs(here[order + 1]).max()
        np.testing.assert_allclose(
            here[order + 1], (after[order] - before[order]) / (2 * step), atol=1e-6 * size
        )


@pytest.mark.parametrize("kind", UNITS)
def test_extremes_are_those_of_a_fine_grid_and_are_reached(one, kind):
    found = getattr(one.extremes(), kind)
    grid = getattr(one.at(np.linspace(0.0, one.period, 40001)), kind)
    size = np.abs(grid).max(axis=0)
    for value, time, expected in (
        (found.lower, found.lower_time, grid.min(axis=0)),
        (found.upper, found.upper_time, grid.max(axis=0)),
    ):
        np.testing.assert_allclose(value, expected, atol=1e-6 * size.max())
        assert np.all((0.0 <= time) & (time <= one.period))
        reached = np.diagonal(getattr(one.at(time), kind))
        np.testing.assert_allclose(reached, value, atol=1e-10 * size.max())
    assert np.all(found.lower <= grid.min(axis=0) + 1e-10 * size)
    assert np.all(found.upper >= grid.max(axis=0) - 1e-10 * size)


def test_a_joint_that_stands_still_stays_at_its_centre():
    still = Fourier(2.0, np.array([0.3, -0.4]), *np.zeros((2, 2, 0)))
    found = still.extremes()
    for side in (found.position.lower, found.position.upper):
        np.testing.assert_array_equal(side, [0.3, -0.4])
    for kind in list(UNITS)[1:]:
        assert not np.any(getattr(found, kind))
    np.testing.assert_array_equal(still.at(np.linspace(0, 2, 5)).position, np.tile([0.3, -0.4], (5, 1)))


@pytest.mark.parametrize("by", [0.9, -1.3])
def test_shifted_begins_later_in_the_same_period(one, by):
    time = np.linspace(0.0, one.period, 50)
    long = replace(one, periods=5)
    states, later = one.shifted(by).at(time), long.at(time + by + one.period)
    for kind in UNITS:
        np.testing.assert_allclose(getattr(states, kind), getattr(later, kind), atol=1e-7)
    assert one.shifted(by).periods == one.periods
    found, before = one.shifted(by).extremes(), one.extremes()
    for kind in UNITS:
        np.testing.assert_allclose(getattr(found, kind)[:2], getattr(before, kind)[:2], rtol=1e-9, atol=1e-9)


def test_scaled_about_its_centre(one):
    time = np.linspace(0.0, one.period, 50)
    whole, part = one.at(time), one.scaled(0.3).at(time)
    np.testing.assert_allclose(part.position - one.centre, 0.3 * (whole.position - one.centre), atol=1e-12)
    for kind in list(UNITS)[1:]:
        np.testing.assert_allclose(getattr(part, kind), 0.3 * getattr(whole, kind), atol=1e-9)
    assert part.position.shape == (50, one.dof)
    assert one.scaled(0.3).periods == one.periods


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: series(period=0.0), BadLimits, "period .* expected at least"),
        (lambda: series(period=np.nan), BadLimits, "period .* expected at least"),
        (lambda: series(periods=0), BadLimits, "period .* expected at least"),
        (lambda: replace(series(), cosine=np.zeros((3, 4))), BadLimits, r"sine \(3, 5\), cosine \(3, 4\)"),
        (lambda: replace(series(), centre=np.zeros(2)), BadLimits, r"centre \(2,\)"),
        (lambda: series().at(np.array([3.8])), OutsideTrajectory, "time 3.8 s is outside .* from 0 to 3.7 s"),
    ],
)
def test_what_makes_no_series_and_times_outside_it_are_refused(make, error, message):
    with pytest.raises(error, match=message):
        make()
