"""The band about the nominal torque: as wide as drawn arms need it, in general and by each motion."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.search.delivery import inside_kinematics
from exidyn.trajectories.search.torque_bound import AIM, TorqueBound, share_beyond, with_own_factor
from exidyn.trajectories.search.torque_spread import DRAWS, spread_of

from ...parts.plans.excitation import goal
from ...parts.small import two_joints


def model(tolerance=0.2):
    of = two_joints.model()
    return replace(of, robot=replace(of.robot, inertial_tolerance=tolerance))


def covariance(of):
    return np.diag(np.square([prior.std for prior in of.priors]))


def spread(of, share=0.95, residual=(0.0, 0.0), seed=0):
    return spread_of(covariance(of), share, np.array(residual), of.regressor(two_joints.motion(400, seed)))


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
    without, unexplained = spread(model()), spread(model(), residual=(0.0, 3.0))
    np.testing.assert_allclose(unexplained.band(columns)[:, 0], without.band(columns)[:, 0])
    expected = np.hypot(without.band(columns)[:, 1], 3.0 * without.factor)
    np.testing.assert_allclose(unexplained.band(columns)[:, 1], expected)


def unsure(residual=0.0):
    return goal(model(), spread=spread(model(), residual=(residual, residual)))


def states():
    random = np.random.default_rng(3)
    series = Fourier(5.0, np.zeros(2), *random.normal(size=(2, 2, 3)))
    return inside_kinematics(series, two_joints.arm().limits, 0.9).every(0.02)


def edge(of):
    """Limits that the band just touches."""
    bound = TorqueBound(of.model, np.full(2, np.inf), of.payloads, of.spread)
    return np.max(np.abs(bound.of("")(states())), axis=0)


def test_few_arms_pass_limits_that_a_band_of_the_own_factor_touches():
    of = unsure()
    narrow = with_own_factor(of, states(), edge(of))
    assert narrow.spread.factor < of.spread.factor == narrow.spread.widest
    assert 0.8 * AIM * 0.05 <= share_beyond(narrow, states(), edge(narrow)) <= AIM * 0.05
    assert share_beyond(of, states(), edge(of)) < share_beyond(narrow, states(), edge(narrow))
    far = with_own_factor(of, states(), np.array([1.0, 2.0]) * edge(of))
    assert far.spread.factor <= narrow.spread.factor
    limit = 0.9 * edge(of)  # torque that no parameter explains counts for every arm
    assert share_beyond(unsure(2.0), states(), limit) > share_beyond(of, states(), limit)


def test_a_motion_that_no_limit_stops_needs_no_band():
    of = with_own_factor(unsure(), states(), 10.0 * edge(unsure()))
    assert of.spread.factor == 0.0
    bound = TorqueBound(of.model, np.full(2, 100.0), of.payloads, of.spread)
    assert not np.any(bound.band(states(), ""))
    near = with_own_factor(of, states(), 0.9 * edge(unsure()))  # the same goal beside limits that do
    assert near.spread.factor > 0.0


def test_without_a_spread_nothing_changes():
    assert spread(model(0.0)) is None  # all is exact, or friction without priors
    of = goal()
    assert with_own_factor(of, states(), np.ones(2)) is of
    assert share_beyond(of, states(), np.zeros(2)) == 0.0
