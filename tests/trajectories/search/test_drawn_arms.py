"""A motion's own factor: just wide enough that few of the drawn arms pass a limit."""

from dataclasses import replace

import numpy as np

from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.search.drawn_arms import AIM, share_beyond, with_own_factor
from exidyn.trajectories.search.shrink import inside_kinematics
from exidyn.trajectories.search.torque_bound import TorqueBound
from exidyn.trajectories.search.torque_spread import spread_of

from ...parts.plans.excitation import goal
from ...parts.small import two_joints


def unsure(residual=0.0):
    of = two_joints.model()
    of = replace(of, robot=replace(of.robot, inertial_tolerance=0.2))
    covariance = np.diag(np.square([prior.std for prior in of.priors]))
    columns = of.regressor(two_joints.motion(400))
    return goal(of, spread=spread_of(covariance, 0.95, np.full(2, residual), columns))


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
    own = with_own_factor(of, states(), edge(of))
    assert own.spread.factor < of.spread.factor == own.spread.widest
    assert 0.8 * AIM * 0.05 <= share_beyond(own, states(), edge(own)) <= AIM * 0.05
    assert share_beyond(of, states(), edge(of)) < share_beyond(own, states(), edge(own))


def test_far_from_the_limits_a_band_may_be_narrower_still():
    of = unsure()
    near, far = (with_own_factor(of, states(), np.array([1.0, share]) * edge(of)) for share in (1.0, 2.0))
    assert far.spread.factor <= near.spread.factor


def test_a_motion_that_no_limit_stops_needs_no_band():
    of = with_own_factor(unsure(), states(), 10.0 * edge(unsure()))
    assert of.spread.factor == 0.0
    bound = TorqueBound(of.model, np.full(2, 100.0), of.payloads, of.spread)
    assert not np.any(bound.band(states(), ""))
    near = with_own_factor(of, states(), 0.9 * edge(unsure()))  # the same goal beside limits that do
    assert near.spread.factor > 0.0


def test_what_no_parameter_explains_counts_for_every_arm():
    with_noise, without = unsure(2.0), unsure()
    limit = 0.9 * edge(without)
    assert share_beyond(with_noise, states(), limit) > share_beyond(without, states(), limit)


def test_without_a_spread_nothing_changes():
    of = goal()
    assert with_own_factor(of, states(), np.ones(2)) is of
    assert share_beyond(of, states(), np.zeros(2)) == 0.0
