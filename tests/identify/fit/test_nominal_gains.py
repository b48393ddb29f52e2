"""What the tolerance of nominal gains does to an estimate is what other gains would have made of it."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.fit.estimators import maximum_likelihood, weighted
from exidyn.identification.fit.estimators.nominal_gains import given_nominal, slope

from ...parts.small.two_joints import GAIN, equations, white

STEP = 1e-4
"""Relative step of a gain."""
TOLERANCE = np.array([0.1, 0.05])


@pytest.fixture(scope="module")
def system():
    exact, _ = equations(rows=600, gain_tolerance=TOLERANCE)
    return white(exact, np.array([0.02, 0.05]))


def test_values_move_with_the_gains_as_stated(system):
    before = weighted(system)
    for joint in range(2):
        step = STEP * GAIN[joint] * np.eye(2)[joint]
        moved = (weighted(replace(system, gain=GAIN + step)).values - before.values) / step[joint]
        expected = slope(before)[:, joint]
        # the joint's noise and so its weight change with its gain, a little
        np.testing.assert_allclose(moved, expected, rtol=0.03, atol=0.03 * np.abs(expected).max())


def test_covariance_is_that_of_noise_and_that_of_gains(system):
    estimate, count = weighted(system), len(system.names)
    gains = np.diag(TOLERANCE * np.abs(GAIN)) ** 2
    by_gain = slope(estimate)
    np.testing.assert_allclose(estimate.covariance[count:, count:], gains)
    np.testing.assert_allclose(
        estimate.covariance[:count, :count], given_nominal(estimate) + by_gain @ gains @ by_gain.T, rtol=1e-9
    )
    without = weighted(replace(system, gain_tolerance=0.0))
    np.testing.assert_allclose(given_nominal(estimate), without.covariance[:count, :count], rtol=1e-6)
    assert np.all(estimate.std > without.std)


def test_nominal_gains_are_not_estimated_and_unstated_ones_have_no_tolerance(system):
    estimate = weighted(system)
    assert np.all(estimate.gain_std > 0.0)
    assert not np.any(estimate.gain_estimated)
    loaded, _ = equations(rows=600, payload=True, gain_tolerance=TOLERANCE)
    assert np.all(maximum_likelihood(white(loaded, np.array([0.02, 0.05]))).gain_estimated)
    estimate = weighted(replace(system, gain=np.ones(2)))
    assert not np.any(estimate.gain_std)
    assert estimate.nominal_gains
