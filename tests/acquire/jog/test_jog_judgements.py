"""Judgements of a jog, from courses whose every sample is known."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.jog.effort import flange_travel, torque_at_rest
from exidyn.acquire.jog.judgements import Verdict, judge
from exidyn.acquire.jog.there_and_back import Course, Travel, run_limits, there_and_back
from exidyn.identification.robot_files.robot_file import read_model

from ...parts.runs.run_parts import MODEL, ROBOT

pytestmark = pytest.mark.clocked(patient=True)

HERE = np.radians([0.0, -126.0, -64.0, -72.0, -72.0, -72.0])
WAY = Travel.of(ROBOT, 1, np.radians(2.0))
COUPLING = np.eye(6)
COUPLING[4, 3], COUPLING[5, 3:5] = 0.2, (0.3, -0.1)
UNCOUPLED = read_model("kr270")
COUPLED = replace(UNCOUPLED, robot=replace(UNCOUPLED.robot, coupling=COUPLING))


def course(model=MODEL, way=WAY, here=HERE, friction=10.0, noise=0.5, torque=False):
    """An arm that follows at once, with this friction [N m] at every joint."""
    robot = model.robot
    states = there_and_back(here, way, run_limits(robot), 0.004).every(0.004)
    random = np.random.default_rng(0)
    at_drives = torque_at_rest(model, states.position) + friction * np.sign(states.velocity)
    at_drives += noise * random.normal(size=at_drives.shape)
    nothing = np.full_like(at_drives, np.nan)
    current = nothing if torque else at_drives / robot.drive_gain
    at_joints = at_drives @ np.linalg.inv(robot.to_motors).T if torque else nothing
    return Course(states.position, states.velocity, states.position.copy(), nothing, current, at_joints)


def found(text, name):
    return next(one for one in text if one.name == name)


def test_friction_and_gravity_are_distinguished_as_they_are():
    text = judge(course(), WAY, MODEL)
    assert found(text, "friction with the motion").value == pytest.approx(10.0, abs=0.2)
    nominal = torque_at_rest(MODEL, HERE[None])[0, 1]
    gravity = found(text, "gravity torque")
    assert gravity.value == pytest.approx(nominal, rel=0.02)
    assert (gravity.low, gravity.high) == pytest.approx((0.75 * nominal, nominal / 0.75), rel=0.02)
    assert found(text, "way").value == pytest.approx(1.0)


@pytest.mark.parametrize("joint", [3, 4, 5])
def test_torques_of_a_coupled_wrist_are_as_its_drives_feel_them(joint):
    way = Travel.of(COUPLED.robot, joint, np.radians(-2.0))
    here = np.array([0.0, -1.0, 0.5, 0.3, 1.0, 0.2])
    for torque in (False, True):
        text = judge(course(COUPLED, way, here, friction=1.0, noise=0.01, torque=torque), way, COUPLED)
        nominal = torque_at_rest(COUPLED, here[None])[0, joint]
        alone = torque_at_rest(UNCOUPLED, here[None])[0]
        assert nominal == pytest.approx((COUPLED.robot.to_motors @ alone)[joint])
        assert found(text, "gravity torque").value == pytest.approx(nominal, rel=0.05, abs=0.05)
        assert found(text, "friction with the motion").value == pytest.approx(1.0, abs=0.05)


def test_one_that_goes_to_each_command_in_a_step_is_not_judged_by_its_current():
    stepping = course()
    slow = replace(stepping, velocity=0.6 * stepping.speed)
    friction = found(judge(slow, WAY, MODEL), "friction with the motion")
    assert friction.verdict is Verdict.UNKNOWN
    assert "is 0.60 of the commanded speed there and 0.60 back" in friction.text


def test_a_speed_that_is_measured_in_coarse_steps_is_no_other_speed():
    """As a motor with the MIT frame does, whose steps are 0.84 of two at this speed."""
    seen = course()
    step = 0.42 * WAY.speed
    coarse = replace(seen, velocity=step * np.rint(seen.speed / step))
    assert found(judge(coarse, WAY, MODEL), "friction with the motion").verdict is Verdict.RIGHT


def test_friction_below_noise_is_not_judged():
    friction = found(judge(course(friction=0.0), WAY, MODEL), "friction with the motion")
    assert friction.verdict is Verdict.UNKNOWN
    assert abs(friction.value) < friction.low


def test_friction_that_could_be_another_each_way_leaves_small_gravity_open():
    output = judge(course(friction=100.0), WAY, MODEL)
    assert found(output, "gravity torque").verdict is Verdict.UNKNOWN
    assert "jog it where gravity is larger" in found(output, "gravity torque").text
    assert found(output, "encoder zero").verdict is Verdict.UNKNOWN


def test_a_wrong_zero_is_seen_from_the_angle_on_that_is_reported():
    """Within it gravity would be as measured; well beyond it, it is not."""
    way = Travel.of(ROBOT, 1, np.radians(-2.0))
    zero = found(judge(course(way=way), way, MODEL), "encoder zero")
    assert "+" in zero.text
    angle = float(zero.text.split("+")[1].split()[0])
    off = HERE.copy()
    off[1] += np.radians(2.0 * angle)
    shown = replace(course(way=way, here=off), position=course(way=way).position)
    shown = replace(shown, commanded=course(way=way).commanded)
    assert found(judge(shown, way, MODEL), "gravity torque").verdict is Verdict.WRONG


def test_silent_samples_are_left_out():
    whole = course()
    position, current = whole.position.copy(), whole.current.copy()
    position[::7] = current[::7] = np.nan
    text = judge(replace(whole, position=position, current=current), WAY, MODEL)
    assert [one.verdict for one in text[:4]] == [Verdict.RIGHT] * 4


def test_one_that_was_stopped_early_shows_nothing():
    whole = course()
    rows = np.flatnonzero(np.abs(whole.speed[:, 1]) > 0)[:20]
    early = Course(*(getattr(whole, name)[: rows[-1]] for name in Course.__dataclass_fields__))
    text = judge(early, WAY, MODEL)
    assert [one.verdict for one in text] == [Verdict.UNKNOWN]
    nothing = Course(*(getattr(whole, name)[:0] for name in Course.__dataclass_fields__))
    assert judge(nothing, WAY, MODEL)[0].verdict is Verdict.UNKNOWN


def test_the_flange_goes_where_the_geometry_states():
    """The first joint of the cobot turns about the vertical."""
    way = Travel.of(ROBOT, 0, np.radians(10.0))
    flange = flange_travel(ROBOT, HERE, way)
    assert flange.axis == pytest.approx([0.0, 0.0, 1.0])
    assert flange.moved[2] == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.norm(flange.moved) > 0.1
