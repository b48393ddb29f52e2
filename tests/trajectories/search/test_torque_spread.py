"""The band about the nominal torque: as wide as drawn arms need it, at all joints and times together."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.trajectories.search.torque_spread import DRAWS, spread_of

from ...parts.small import two_joints

NOTHING = np.zeros(2)


def model(tolerance=0.2):
    of = two_joints.model()
    return replace(of, robot=replace(of.robot, inertial_tolerance=tolerance))


def covariance(of):
    return np.diag(np.square([prior.std for prior in of.priors]))


def spread(of, share=0.95, residual=NOTHING, seed=0):
    return spread_of(covariance(of), share, residual, of.regressor(two_joints.motion(400, seed)))


def test_a_band_holds_all_of_the_torque_of_its_share_of_arms():
    """Of another motion than the one that it was made for, and of other draws."""
    of, random = model(), np.random.default_rng(7)
    motion = two_joints.motion(600, seed=3)
    columns = of.regressor(motion)
    std = np.sqrt(np.diag(covariance(of)))
    drawn = np.where(np.isfinite(std), std, 0.0)[:, None] * random.normal(size=(len(std), 4000))
    inside = np.abs(columns @ drawn) <= spread(of).band(columns)[:, :, None] + 1e-12
    assert np.mean(np.all(inside, axis=(0, 1))) == pytest.approx(0.95, abs=0.015)


def test_arms_beyond_a_limit_are_counted_over_joints_and_times():
    of, motion = model(), two_joints.motion(600, seed=3)
    nominal = of.torque(motion, of.nominal_values)
    band = spread(of).band(of.regressor(motion))
    limit = np.max(np.abs(nominal) + band, axis=0)
    peaks = spread(of).peaks(of, motion, nominal)
    beyond = [spread(of).share_beyond(peaks, share * limit) for share in (1.0, 0.7, 0.1)]
    assert beyond[0] <= 0.05 < beyond[1] < beyond[2] == 1.0
    assert peaks.shape == (DRAWS, 2)
    assert spread(of).share_beyond(peaks, np.full(2, np.inf)) == 0.0


def test_what_is_known_better_needs_less_room():
    columns = model().regressor(two_joints.motion(50))
    wide, half = (spread(model(tolerance)).band(columns) for tolerance in (0.2, 0.1))
    np.testing.assert_allclose(half, 0.5 * wide)
    assert np.all(spread(model(), 0.5).band(columns) < spread(model(), 0.95).band(columns))


def test_torque_that_no_parameter_explains_needs_room():
    columns = model().regressor(two_joints.motion(50))
    without, unexplained = spread(model()), spread(model(), residual=np.array([0.0, 3.0]))
    np.testing.assert_allclose(unexplained.band(columns)[:, 0], without.band(columns)[:, 0])
    expected = np.hypot(without.band(columns)[:, 1], 3.0 * without.factor)
    np.testing.assert_allclose(unexplained.band(columns)[:, 1], expected)


def test_nothing_is_unsure_where_all_is_exact_or_unknown():
    of = model(0.0)  # friction without priors
    assert spread(of) is None
