from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.robot import Limits
from exidyn.trajectories.errors import BadLimits
from exidyn.trajectories.limits.brake import stoppable, stopping_reach, stopping_reach_gradient
from exidyn.trajectories.limits.moves import brake_reach
from exidyn.trajectories.trajectory import States

pytestmark = pytest.mark.clocked

STATES = 400


def random_case(seed, joints=6):
    """Limits and states of very different sizes, accelerations up to 40 % beyond their limits."""
    random = np.random.default_rng(seed)
    far = np.full(joints, np.inf)
    forward, backward = 10 ** random.uniform(0, 1.5, (2, joints))
    limits = Limits(-far, far, far, forward, 10 ** random.uniform(0.7, 3, joints), far, -far, -backward)
    velocity = random.normal(size=(STATES, joints)) * 10 ** random.uniform(-3, 0.5, (STATES, joints))
    share = random.uniform(-1.4, 1.4, (STATES, joints))
    return velocity, np.where(share > 0, forward, backward) * share, limits


@pytest.mark.parametrize("seed", range(4))
def test_it_is_how_far_ruckig_goes(seed):
    velocity, acceleration, limits = random_case(seed)
    found = stopping_reach(velocity, acceleration, limits)
    expected = brake_reach(velocity, acceleration, limits)
    size = 1.0 + np.max(np.abs(expected))
    np.testing.assert_allclose(found.lower, expected.lower, atol=1e-12 * size)
    np.testing.assert_allclose(found.upper, expected.upper, atol=1e-12 * size)


@pytest.mark.parametrize("seed", range(4))
def test_derivatives_are_those_of_the_reach(seed):
    """Central differences; where forward and backward differ there is a kink within the step."""
    velocity, acceleration, limits = random_case(seed)
    slopes = stopping_reach_gradient(velocity, acceleration, limits)
    step = 1e-6
    for shift, found in (((step, 0.0), slopes[0]), ((0.0, step), slopes[1])):
        here = np.stack(stopping_reach(velocity, acceleration, limits))
        after = np.stack(stopping_reach(velocity + shift[0], acceleration + shift[1], limits))
        before = np.stack(stopping_reach(velocity - shift[0], acceleration - shift[1], limits))
        smooth = np.abs(after - 2 * here + before) < 1e-3 * step
        assert np.mean(smooth) > 0.99
        expected = (after - before) / (2 * step)
        error = np.abs(expected - np.stack(found))[smooth]
        assert np.max(error) < 2e-3  # half of what a kink below the threshold above is worth
        assert np.quantile(error, 0.995) < 5e-6


def test_a_stop_worked_out_by_hand():
    """From 1 rad/s with jerk 10: to -sqrt(10) rad/s^2 in 0.316 s and back, a distance of 0.316 rad."""
    one = np.ones(1)
    limits = replace(Limits.none(1), jerk=10 * one)
    reach = stopping_reach(one[None], 0 * one[None], limits)
    np.testing.assert_allclose(reach, [[[0.0]], [[np.sqrt(0.1)]]], atol=1e-15)
    # With at most 1 rad/s^2: 0.1 s to it, 0.9 s at it, 0.1 s from it: half of 1 rad/s over 1.1 s.
    reach = stopping_reach(one[None], 0 * one[None], replace(limits, acceleration_lower=-one))
    np.testing.assert_allclose(reach, [[[0.0]], [[0.55]]], atol=1e-15)
    still, (_, _, limits) = np.zeros((3, 6)), random_case(0)  # from rest it goes nowhere, with no slope
    assert not np.any(stopping_reach(still, still, limits))
    assert not np.any(stopping_reach_gradient(still, still, limits))


def test_stoppable_is_position_and_reach_within_the_limits():
    one = np.ones(1)
    limits = replace(Limits.none(1), jerk=10 * one, position_lower=-one, position_upper=one)
    position = np.array([[0.6], [0.7], [-0.99], [1.01], [0.0]])
    velocity = np.array([[1.0], [1.0], [1.0], [0.0], [np.nan]])  # goes on for 0.316 rad
    states = States(np.arange(5.0), position, velocity, *np.zeros((2, 5, 1)))
    np.testing.assert_array_equal(stoppable(states, limits)[:, 0], [True, False, True, False, False])


@pytest.mark.parametrize("jerk", [0.0, -1.0, np.nan, np.inf])
def test_a_jerk_that_none_can_stop_with(jerk):
    limits = replace(Limits.none(2), jerk=np.array([1.0, jerk]))
    with pytest.raises(BadLimits, match="joint 2: jerk limit"):
        stopping_reach(np.ones((1, 2)), np.zeros((1, 2)), limits)
