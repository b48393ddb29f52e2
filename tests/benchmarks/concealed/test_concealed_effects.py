"""Effects are in the robot and in its recordings, and nowhere else."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from parts.concealed.effects.outside import OUTSIDE
from parts.concealed.effects.vocabulary import VOCABULARY, places
from parts.concealed.plant.body import turn
from parts.concealed.plant.closed_loop import STEP, at_rest, run
from parts.concealed.plant.forces import gyration, misread
from parts.concealed.recordings.record import PLANS, drags, record, rms
from parts.concealed.recordings.write import urdf
from parts.concealed.robots.arms import ARMS

from .robots import small_arm, sound, sticking, swing

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", [*VOCABULARY, *OUTSIDE])
def test_an_effect_changes_the_robot_and_shows_no_owner(name):
    effect = (VOCABULARY | OUTSIDE)[name]
    robot = sound(list(ARMS)[len(name) % len(ARMS)])
    joint = places(name, robot)[-1]
    concealed = effect(robot, joint, 1.0, np.random.default_rng(4))
    again = effect(robot, joint, 1.0, np.random.default_rng(4))
    assert all(0 <= place < robot.arm.joints for place in concealed.joints)
    assert repr(concealed) == repr(again)
    real = (concealed.robot.machine, concealed.robot.recorder)
    assert repr(real) != repr((concealed.sound.machine, concealed.sound.recorder))
    # A tool that its owner knows of is nominal with and without the effect.
    nominal, before = concealed.robot.prior, concealed.sound.prior
    np.testing.assert_array_equal(nominal.body.mass, before.body.mass)
    np.testing.assert_array_equal(nominal.gain, before.gain)
    for term, there in nominal.terms.items():  # a term may be left out, none is given away
        assert np.all(before.terms[term] >= there)


@pytest.mark.parametrize("name", ["uneven_encoder", "swinging_tool", "spinning_tool", "dragging_brake"])
def test_what_has_no_name_is_in_a_recording_from_the_strength_of_zero_on(name, at_once):
    robot = sticking(small_arm(lean=1))
    for strength in (0.0, 5.0):
        concealed = OUTSIDE[name](robot, 1, strength, np.random.default_rng(4))
        there, gone = (
            record(one, PLANS["identify_a"], 5).current * robot.arm.gain
            for one in (concealed.robot, concealed.sound)
        )
        seen = np.max(rms(there - gone) / robot.recorder.floor)
        assert seen > 0.5 if strength else seen == 0.0


def test_a_spindle_is_turned_about_by_a_moment_that_takes_no_power():
    robot = sound("ur10like")
    body, n = robot.machine.body, 6
    model = pin.buildModelFromXML(urdf(replace(robot, prior=robot.prior._replace(body=body))))
    data, turned = model.createData(), np.empty((n, 3, 3))
    position, velocity = np.random.default_rng(2).normal(size=(2, n))
    momentum = np.array([0.3, -0.2, 0.5])
    turn(body.rotation, position, turned)
    torque = gyration(momentum, turned, velocity)
    jacobian = pin.computeJointJacobian(model, data, position, n)[3:]
    np.testing.assert_allclose(torque, jacobian.T @ np.cross(jacobian @ velocity, momentum), atol=1e-12)
    assert velocity @ torque == pytest.approx(0.0, abs=1e-12)


def test_a_tool_on_rubber_weighs_at_rest_what_it_would_on_a_flange():
    robot = sticking(small_arm())
    tool = OUTSIDE["swinging_tool"](robot, 1, 5.0, np.random.default_rng(4))
    held = [at_rest(one.machine, np.full(2, 0.4), np.full(2, 35.0)).load for one in (tool.robot, tool.sound)]
    np.testing.assert_allclose(*held, rtol=1e-9)
    assert np.max(np.abs(held[0])) > 0.0


def test_a_drive_goes_where_an_uneven_encoder_reads(at_once):
    robot = sticking(small_arm())
    wavy = OUTSIDE["uneven_encoder"](robot, 1, 5.0, np.random.default_rng(4)).robot.machine
    path = swing(2, 0.1)
    log = run(wavy, path, np.zeros((220, 2)), np.full(2, 35.0))
    error = [misread(wavy, 1, angle) for angle in log.link[:, 1]]
    np.testing.assert_allclose(log.link[:, 1] - log.position[:, 1], error, atol=1e-12)
    assert np.ptp(error) > wavy.ring[1, 0] > 0.0
    assert log.position[0, 1] == pytest.approx(path[0, 0, 1], abs=1e-4)


def test_a_brake_that_opens_slowly_drags_against_the_motion_and_is_open_then():
    robot = sticking(small_arm())
    slow = OUTSIDE["dragging_brake"](robot, 1, 2.0, np.random.default_rng(4))
    torque, opening = slow.robot.recorder.drag[1]
    velocity = np.tile([0.5, -0.5], (round(12.0 / STEP), 1))
    drag = drags(slow.robot, velocity, len(velocity) + 100)
    assert not np.any(drag[:, 0])
    assert drag[100, 1] == pytest.approx(-torque)
    assert not np.any(drag[100 + round(slow.span[1] / STEP) :])
    assert np.sum(drag[100:, 1]) * STEP == pytest.approx(-torque * (0.5 * opening + 0.65), rel=1e-3)
