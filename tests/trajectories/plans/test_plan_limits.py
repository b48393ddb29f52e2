"""Limits of a plan for the robot at hand: the narrower of both; and jumps of its motion."""

from dataclasses import fields, replace

import numpy as np
import pytest

from exidyn.identification.arm.robot import Limits
from exidyn.trajectories.families import FAMILIES
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.families.sequence import Slowed
from exidyn.trajectories.plans.plan import file_warnings, tightest, within
from exidyn.trajectories.plans.plan_check import COARSEST, FINEST, jumps, nominal_torque, spacing, violations

from ...parts.plans.plans import SAMPLES, fourier, known_plan, phases
from ...parts.small import two_joints

ROBOT = two_joints.arm()


@pytest.mark.parametrize("name", [f.name for f in fields(Limits)])
def test_the_narrower_of_both_counts(name):
    robot = getattr(ROBOT.limits, name)
    inward = 0.1 if name.endswith("_lower") else -0.1
    mixed = robot + inward * np.array([1.0, -1.0])
    limits = tightest(replace(ROBOT.limits, **{name: mixed}), ROBOT.limits)
    np.testing.assert_array_equal(getattr(limits, name), [mixed[0], robot[1]])


def test_limits_that_are_not_given_narrow_nothing():
    plan = replace(known_plan(), limits=Limits.none(2))
    held = within(plan, ROBOT)
    for f in fields(Limits):
        np.testing.assert_array_equal(getattr(held.limits, f.name), getattr(ROBOT.limits, f.name))
    np.testing.assert_array_equal(nominal_torque(plan, two_joints.model()).use.upper, ROBOT.limits.torque)


def test_an_edited_plan_without_a_robot_is_compared_with_its_own_limits():
    assert file_warnings(known_plan(), ROBOT) == file_warnings(known_plan()) == []
    (sentence,) = file_warnings(replace(known_plan(), edited=True))
    assert "--robot" in sentence


def test_a_tick_that_the_file_states_hides_neither_torque_nor_stops():
    quick = Fourier(0.5, np.zeros(2), np.full((2, 1), 0.3), np.zeros((2, 1)), 4)
    model = two_joints.model()
    fine, coarse = (known_plan(quick, tick=tick) for tick in (0.001, 0.5))
    used = [nominal_torque(plan, model).use.share for plan in (fine, coarse)]
    np.testing.assert_allclose(used[1], used[0], rtol=1e-3)
    near = replace(fine.limits, position_upper=np.full(2, 0.31), jerk=np.full(2, 60.0))
    stops = [
        [v for v in violations(replace(plan, limits=near)) if "stop begun" in v] for plan in (fine, coarse)
    ]
    assert stops[0]
    assert len(stops[0]) == len(stops[1])


def test_samples_are_as_close_as_the_motion_needs():
    assert spacing(known_plan(fourier().scaled(1.0), tick=0.001)) == 0.001
    slow = Fourier(10.0, np.zeros(2), np.full((2, 1), 0.3), np.zeros((2, 1)))
    assert spacing(known_plan(slow, tick=0.1)) == COARSEST
    buzz = Fourier(0.004, np.zeros(2), np.full((2, 1), 1e-6), np.zeros((2, 1)), 10)
    assert spacing(known_plan(buzz, tick=0.004)) == FINEST


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("speed", [1.0, 0.07])
def test_no_family_jumps(family, speed):
    plan = known_plan(Slowed(SAMPLES[family](), speed))
    assert jumps(plan, plan.tick) == []


@pytest.mark.parametrize(
    ("name", "size", "unit"),
    [("position", 1e-3, "rad"), ("velocity", 0.05, "rad/s"), ("acceleration", 0.5, "")],
)
def test_a_piece_that_does_not_join_is_named(name, size, unit):
    motion = phases()
    states = getattr(motion, name).copy()
    states[2, 1] += size
    (sentence,) = [
        text
        for text in violations(known_plan(replace(motion, **{name: states})))
        if text.startswith(f"elbow: {name} jumps by more than ")
    ]
    assert unit in sentence
    value, time = (float(part.split()[0]) for part in (sentence.split("than ")[1], sentence.split("at ")[-1]))
    assert 0.5 * size < value <= size
    assert abs(time - motion.start[2]) < known_plan().tick
