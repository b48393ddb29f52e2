from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.run.before import checked
from exidyn.acquire.run.errors import NotAllowed
from exidyn.identify.effects import known_parameters
from exidyn.identify.recordings.recording import KnownPayload
from exidyn.identify.robot_files.robot_file import read_model
from exidyn.trajectories.plans.plan import Plan

from ...parts.runs.run_parts import LIMITS, MODEL, motion


def plan(**other):
    return Plan.of(motion(), MODEL, **({"tick": 0.002} | other))


def robot(**limits):
    return replace(MODEL, robot=replace(MODEL.robot, limits=replace(MODEL.robot.limits, **limits)))


def test_a_plan_for_the_robot_at_hand_may_run():
    found = checked(plan(), MODEL)
    assert not found.warnings
    assert np.array_equal(found.limits.jerk, LIMITS.jerk)


def test_another_robot_is_refused():
    with pytest.raises(NotAllowed, match="kr270"):
        checked(plan(), read_model("kr270"))


def test_other_limits_are_refused_and_named():
    with pytest.raises(NotAllowed, match="limit velocity of joint1"):
        checked(plan(), robot(velocity=0.5 * LIMITS.velocity))


def test_a_plan_beyond_the_limits_is_refused_but_may_be_slow_enough():
    narrow = robot(velocity=0.2 * LIMITS.velocity, velocity_lower=-0.2 * LIMITS.velocity)
    fast = Plan.of(motion(), narrow, tick=0.002)
    with pytest.raises(NotAllowed, match="slower .exidyn record --speed"):
        checked(fast, narrow)
    assert checked(fast, narrow, speed=0.1).plan.trajectory.duration == 10 * motion().duration


def test_torque_counts_with_what_hangs_on_the_flange():
    heavy = KnownPayload("L", known_parameters(60.0, (0.0, 0.0, 0.3), (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)))
    with pytest.raises(NotAllowed, match="torque"):
        checked(plan(), MODEL, payload=heavy)


def test_limits_not_given_are_finite_and_bear_the_motion():
    without_limits = robot(
        acceleration=np.full(6, np.inf), acceleration_lower=np.full(6, -np.inf), jerk=np.full(6, np.inf)
    )
    found = checked(Plan.of(motion(), without_limits, tick=0.002), without_limits).limits
    reached = motion().extremes()
    assert np.all(np.isfinite(found.acceleration) & np.isfinite(found.jerk))
    assert np.all(found.acceleration >= reached.acceleration.upper)
    assert np.all(found.jerk >= reached.jerk.upper)


def test_another_model_of_the_same_arm_is_a_warning():
    other = replace(MODEL, effects=MODEL.effects[:-1])
    assert "torques" in checked(plan(), other).warnings[0]
