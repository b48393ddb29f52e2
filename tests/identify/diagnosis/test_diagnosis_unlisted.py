"""What has no name in the vocabulary: its torque is that of the physics it is called after."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.newton_euler import joints_of
from exidyn.identification.diagnosis.candidates import candidates, hypotheses
from exidyn.identification.diagnosis.candidates.contact_event import flange
from exidyn.identification.diagnosis.candidates.kinematics import across
from exidyn.identification.diagnosis.runs.driven import Driven, Unloaded, link_torque
from exidyn.identification.effects import RigidBody, ViscousFriction
from exidyn.identification.model import Model

from ...parts.runs.robots import six_axis
from ...parts.small import two_joints

OUTSIDE = ("hose_spring", "supply_sag", "current_crosstalk", "neighbour_friction", "axis_misalignment")
MODEL = two_joints.model()
VALUES = two_joints.true_values(MODEL)


def driven() -> Driven:
    motion = two_joints.motion(4000, rate=1000.0)
    bodies, _ = MODEL.bodies_apart(VALUES, "")
    still = np.zeros_like(motion.position)
    return Driven("", SimpleNamespace(), motion, still, Unloaded(bodies, motion)).after(MODEL, VALUES)


def one(name: str, **shape: float):
    found = [one for one in hypotheses(name, MODEL) if not shape or one.shape == shape]
    return found[0]


def test_a_hose_takes_the_power_that_its_stretching_does():
    run = driven()
    stiffness, anchor = 40.0, np.array([0.3, -0.2, 1.1])
    torque = one("hose_spring").columns(run) @ np.array([stiffness, *(stiffness * anchor)])
    place = flange(MODEL, run.motion)[0]
    energy = 0.5 * stiffness * np.sum((place - anchor) ** 2, axis=1)
    power = np.gradient(energy, run.motion.time)
    given = np.sum(torque * run.motion.velocity, axis=1)
    np.testing.assert_allclose(given[2:-2], power[2:-2], atol=2e-3 * np.max(np.abs(power)))


def test_columns_of_supply_crosstalk_and_a_neighbours_friction():
    run = driven()
    column = one("supply_sag").columns(run)[:, :, 0]
    drawn = np.maximum(run.torque * run.motion.velocity, 0.0).sum(axis=1)
    assert np.any(drawn == 0.0)
    np.testing.assert_allclose(column, run.torque * drawn[:, None])
    run = driven()
    leak = one("current_crosstalk", other_joint=1.0)
    assert leak.joints == (1,)
    column = leak.columns(run)[:, :, 0]
    np.testing.assert_array_equal(column[:, 1], run.torque[:, 0])
    assert not np.any(column[:, 0])
    run = driven()
    with_friction = one("neighbour_friction", other_joint=2.0)
    assert with_friction.joints == (0,)
    torque = with_friction.columns(run)[:, 0] @ np.array([0.6, 0.8])
    fast = np.abs(run.motion.velocity[:, 0]) > 0.02
    turned = torque * np.sign(run.motion.velocity[:, 0])
    expected = 0.6 * np.cos(run.motion.position[:, 1]) + 0.8 * np.sin(run.motion.position[:, 1])
    np.testing.assert_allclose(turned[fast], expected[fast], rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("joint", range(1, 6))
def test_bodies_beyond_a_misaligned_axis_take_the_torque_of_an_arm_that_was_built_so(joint):
    robot = six_axis()
    model = Model(robot, (RigidBody(),))
    time = np.arange(0.0, 2.0, 0.002)
    phase = np.arange(6.0)
    states = tuple(rate * wave(3.0 * time[:, None] + phase) for rate, wave in ((1, np.sin), (3, np.cos)))
    states = (*states, -9.0 * states[0])
    still = np.zeros_like(states[0])
    motion = Motion(time, *states, load=still, temperature=still)
    bodies = robot.kinematics
    run = Driven("", SimpleNamespace(), motion, still, Unloaded(bodies, motion))
    [candidate] = [each for each in hypotheses("axis_misalignment", model) if each.joints == (joint,)]
    columns = candidate.columns(run)
    for place, direction in enumerate(across(joints_of(bodies)[joint].axis)):
        sides = []
        for sign in (1.0, -1.0):
            built = bodies.copy()
            turned = pin.SE3(pin.exp3(sign * 1e-4 * direction), np.zeros(3))
            built.jointPlacements[joint + 1] = built.jointPlacements[joint + 1] * turned
            sides.append(link_torque(built, *states))
        expected = (sides[0] - sides[1]) / 2e-4 @ robot.to_motors.T
        np.testing.assert_allclose(columns[:, :, place], expected, atol=2e-3 * np.abs(expected).max())


@pytest.mark.parametrize("name", OUTSIDE)
def test_the_search_asks_for_it_and_holds_it_less_likely_than_what_has_a_name(name):
    assert name in {candidate.effect for candidate in candidates(MODEL)}
    assert one(name).prior < 1.0


def test_a_term_that_the_model_has_on_other_joints_is_what_is_missing_most_often():
    """Five times as likely as any other hypothesis, before the data."""
    elbow = replace(MODEL, effects=(RigidBody(), ViscousFriction(("shoulder",))))
    prior = {one.key: one.prior for one in candidates(elbow)}
    assert prior["viscous_friction", (1,), ""] == 5.0 * prior["joint_spring", (1,), ""]
    assert prior["viscous_friction", (0,), ""] == prior["joint_spring", (0,), ""]
