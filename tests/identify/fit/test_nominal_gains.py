"""What the tolerance of nominal gains does to an estimate, and that a value without weight does nothing."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.fit.estimators import consistent, maximum_likelihood, weighted
from exidyn.identification.fit.estimators.least_squares import given_nominal, slope
from exidyn.identification.robot_files.robot_file import parse_model
from exidyn.identification.robot_files.robot_text import model_text

from ...parts.small import two_joints
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


def test_a_nominal_value_without_weight_changes_nothing():
    given, _ = two_joints.equations(payload=True)
    given = two_joints.white(given, np.array([0.01, 0.01]))
    own = np.array([parameter.name[:2] in ("Fv", "Fc", "Of") for parameter in given.base.parameters])
    tolerance = np.where(own, np.inf, 0.05 * np.maximum(np.abs(given.nominal), 0.1))
    estimates = [
        consistent(replace(given, nominal=np.where(own, value, given.nominal), tolerance=tolerance))
        for value in (0.0, 20.0)
    ]
    apart = np.abs(estimates[0].values - estimates[1].values)
    assert np.all(apart < 0.01 * estimates[0].std)


def test_a_row_without_values_reads_as_no_prior_and_back():
    text = model_text(two_joints.model())
    assert 'name = "viscous_friction"' in text
    priors = dict(zip(parse_model(text).names, parse_model(text).priors, strict=True))
    for name in ("Fv1", "Fv2", "Fc1", "Off2"):
        assert (priors[name].value, priors[name].std) == (0.0, np.inf)
