from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.acquire.run.stopping.watch import CommandCheck
from exidyn.drivers import Command
from exidyn.identification.arm.robot import SLIDING

from ....parts.runs.run_parts import CYCLE, LIMITS, ROBOT, START, motion

STEP = CYCLE * LIMITS.velocity


def check(start=START, robot=ROBOT, **window):
    return CommandCheck(robot, LIMITS, CYCLE, start, **window)


def command(position):
    return Command(np.asarray(position, float), np.zeros(6))


def test_a_motion_within_the_limits_passes():
    looking = check()
    assert all(looking.look(command(position)) is None for position in motion().every(CYCLE).position)


@pytest.mark.parametrize(
    ("position", "kind"),
    [
        (START + np.nan, "command"),
        (START + np.inf, "command"),
        (START + 0.5 * STEP, "command acceleration"),
        (START + 2.0 * STEP, "command velocity"),
        (LIMITS.position_upper + 0.1, "command position"),
        (START[:5], "command"),
    ],
)
def test_what_is_not_in_order_is_named(position, kind):
    assert check().look(command(position)).kind == kind


def test_a_command_that_is_not_in_order_is_not_what_the_next_is_held_against():
    looking = check()
    looking.look(command(START + 1.0))
    assert looking.look(command(START)) is None


def test_an_arm_outside_its_limits_may_come_back_but_not_go_further():
    outside = LIMITS.position_upper + 0.2
    assert check(outside).look(command(outside)) is None
    assert check(outside).look(command(outside + 1e-4)).kind == "command position"


def test_the_controllers_window_counts_too():
    looking = check(window_lower=START - 1e-5, window_upper=START + 1e-5)
    assert looking.look(command(START + 2e-5)).kind == "command position"


@pytest.mark.parametrize(("start", "unit"), [(START + 0.5 * STEP, "m/s^2"), (START + 2.0 * STEP, "m/s")])
def test_a_command_of_a_sliding_joint_is_refused_in_metres(start, unit):
    sliding = SimpleNamespace(joints=ROBOT.joints, unit=lambda joint, turning: SLIDING[turning])
    found = check(robot=sliding).look(command(start))
    assert found.unit == unit
    assert f" {unit} exceeds" in found.text


@pytest.mark.parametrize(("share", "kind"), [(1.04, None), (1.06, "command velocity")])
def test_a_velocity_may_exceed_its_limit_by_a_twentieth(share, kind):
    looking, position, step = check(), START, np.zeros(6)
    for speed in np.linspace(0.0, share, 800):
        step = speed * STEP * np.eye(6)[0]
        position = position + step
        found = looking.look(command(position))
        if found is not None:
            break
    assert (found.kind if found else None) == kind
