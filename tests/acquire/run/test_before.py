from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.run.before import check_plan
from exidyn.acquire.run.errors import NotAllowed
from exidyn.identification.effects import known_parameters
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.errors import BadLimits
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_check import limit_use
from exidyn.trajectories.plans.plan_file import parse_plan, plan_text

from ...parts.runs.run_parts import LIMITS, MODEL, motion


def plan(**other):
    return Plan.of(motion(), MODEL, **({"tick": 0.002} | other))


def robot(**limits):
    return replace(MODEL, robot=replace(MODEL.robot, limits=replace(MODEL.robot.limits, **limits)))


def test_a_plan_for_the_robot_at_hand_may_run():
    found = check_plan(plan(), MODEL)
    assert not found.warnings
    assert np.array_equal(found.limits.jerk, LIMITS.jerk)


def test_another_robot_is_refused():
    with pytest.raises(NotAllowed, match="kr270"):
        check_plan(plan(), read_model("kr270"))


def test_other_limits_are_refused_and_named():
    with pytest.raises(NotAllowed, match="limit velocity of joint1"):
        check_plan(plan(), robot(velocity=0.5 * LIMITS.velocity))


def test_a_plan_beyond_the_limits_is_refused_but_may_be_slow_enough():
    narrow = robot(velocity=0.2 * LIMITS.velocity, velocity_lower=-0.2 * LIMITS.velocity)
    fast = Plan.of(motion(), narrow, tick=0.002)
    with pytest.raises(NotAllowed, match="slower .exidyn record --speed"):
        check_plan(fast, narrow)
    assert check_plan(fast, narrow, speed=0.1).plan.trajectory.duration == 10 * motion().duration


def test_torque_counts_with_what_hangs_on_the_flange():
    heavy = KnownPayload("L", known_parameters(60.0, (0.0, 0.0, 0.3), (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)))
    with pytest.raises(NotAllowed, match="torque"):
        check_plan(plan(), MODEL, payload=heavy)


def test_limits_not_given_are_finite_and_bear_the_motion():
    without_limits = robot(
        acceleration=np.full(6, np.inf), acceleration_lower=np.full(6, -np.inf), jerk=np.full(6, np.inf)
    )
    found = check_plan(Plan.of(motion(), without_limits, tick=0.002), without_limits).limits
    reached = motion().extremes()
    assert np.all(np.isfinite(found.acceleration) & np.isfinite(found.jerk))
    assert np.all(found.acceleration >= reached.acceleration.upper)
    assert np.all(found.jerk >= reached.jerk.upper)


def test_another_model_of_the_same_arm_is_a_warning():
    other = replace(MODEL, effects=MODEL.effects[:-1])
    assert "torques" in check_plan(plan(), other).warnings[0]


LIMITED = ("position_lower", "position_upper", "velocity", "velocity_lower", "acceleration",
           "acceleration_lower", "jerk", "torque")  # fmt: skip


def edited(planned, **limits):
    """A plan as it is read after a person changed limits in its file and removed the checksum."""
    changed = replace(planned, limits=replace(planned.limits, **limits), edited=True)
    return parse_plan(plan_text(changed))


def times(planned, factor, names=LIMITED):
    return {name: factor * getattr(planned.limits, name) for name in names}


def swing(size, frequency, robot_model=MODEL):
    """The first joint on a sine of an amplitude [rad] and a frequency [Hz]."""
    sine = np.zeros((6, 1))
    sine[0] = size
    middle = 0.5 * (LIMITS.position_lower + LIMITS.position_upper)
    return Plan.of(Fourier(1.0 / frequency, middle, sine, np.zeros((6, 1)), 2), robot_model, tick=0.002)


FAST = {
    "position": swing(1.1 * np.pi, 0.02),
    "velocity": swing(2.5, 1.8 * LIMITS.velocity[0] / (2 * np.pi * 2.5)),
    "acceleration": swing(1.5 * LIMITS.acceleration[0] / (2 * np.pi) ** 2, 1.0),
    "jerk": swing(1.5 * LIMITS.jerk[0] / (6 * np.pi) ** 3, 3.0),
}
"""Quantity -> a motion of the first joint that exceeds its limit."""


@pytest.mark.parametrize("quantity", FAST)
def test_limits_raised_in_the_file_change_nothing(quantity):
    fast = FAST[quantity]
    with pytest.raises(NotAllowed, match=f"edited by hand.*joint1: {quantity} at "):
        check_plan(edited(fast, **times(fast, 50.0)), MODEL)


@pytest.mark.parametrize("name", ["velocity_lower", "acceleration_lower"])
def test_a_backward_limit_of_the_robot_counts_at_every_speed(name):
    slow = robot(**{name: 0.1 * getattr(LIMITS, name)})
    planned = swing(0.4 * LIMITS.velocity[0], 1.0 / (2 * np.pi), slow)
    raised = edited(planned, **times(planned, 50.0, (name,)))
    with pytest.raises(NotAllowed, match=f"joint1: {name.removesuffix('_lower')} at .* is -"):
        check_plan(raised, slow)
    share = check_plan(raised, slow, speed=0.2)
    used = {use.name: use for use in limit_use(share.plan)}[name.removesuffix("_lower")]
    assert np.array_equal(used.lower, getattr(slow.robot.limits, name))


def test_torque_limits_raised_in_the_file_do_not_count_with_a_payload():
    heavy = KnownPayload("L", known_parameters(60.0, (0.0, 0.0, 0.3), (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)))
    with pytest.raises(NotAllowed, match="torque"):
        check_plan(edited(plan(), **times(plan(), 50.0)), MODEL, payload=heavy)


def test_a_motion_within_the_robots_limits_runs_with_warnings_and_percentages_of_the_robot():
    ready = check_plan(edited(plan(), **times(plan(), 50.0)), MODEL)
    without_checksum, wider = ready.warnings
    assert "no checksum" in without_checksum
    assert "exceed those of cobot, which are used" in wider
    honest = check_plan(plan(), MODEL)
    for here, there in zip(limit_use(ready.plan), limit_use(honest.plan), strict=True):
        assert np.array_equal(here.share, there.share, equal_nan=True)
    assert np.array_equal(ready.torque.use.share, honest.torque.use.share)
    assert np.array_equal(ready.limits.velocity, honest.limits.velocity)


def test_a_file_with_a_new_checksum_widens_nothing_either():
    fast = FAST["velocity"]
    forged = replace(fast, limits=replace(fast.limits, **times(fast, 50.0)))
    with pytest.raises(NotAllowed, match="joint1: velocity at"):
        check_plan(parse_plan(plan_text(forged)), MODEL)


def test_limits_narrowed_in_the_file_hold_the_motion_and_are_named():
    reached = motion().extremes().velocity.upper
    narrow = LIMITS.velocity.copy()
    narrow[2] = 0.5 * reached[2]
    with pytest.raises(NotAllowed, match=r"own file, narrower in velocity of joint3 \(.*joint3: velocity at"):
        check_plan(edited(plan(), velocity=narrow), MODEL)
    narrow[2] = 1.5 * reached[2]
    ready = check_plan(edited(plan(), velocity=narrow), MODEL)
    assert any("narrower than those of cobot" in sentence for sentence in ready.warnings)
    assert ready.plan.limits.velocity[2] == narrow[2]
    assert np.array_equal(ready.limits.velocity, LIMITS.velocity)  # a stop may use all that the robot can


def test_limits_of_the_file_apart_from_those_of_the_robot_are_refused():
    far = edited(plan(), position_lower=LIMITS.position_upper + 1.0, position_upper=LIMITS.position_upper + 2)
    with pytest.raises(BadLimits, match="limits of cobot combined with those in the plan's file"):
        check_plan(far, MODEL)


def test_units_that_are_not_those_of_the_robot_are_refused():
    with pytest.raises(NotAllowed, match="states units m, rad"):
        check_plan(replace(plan(), units=("m", *["rad"] * 5)), MODEL)


def test_a_plan_for_a_robot_of_the_same_name_with_wider_limits_is_refused():
    fast = robot(velocity=2.0 * LIMITS.velocity)
    with pytest.raises(NotAllowed, match="limit velocity of joint1 is"):
        check_plan(Plan.of(motion(), fast, tick=0.002), MODEL)
