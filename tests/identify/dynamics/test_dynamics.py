"""Torque and momentum on scalars, against regressors and Pinocchio."""

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.rigid_regressor import INERTIAL
from exidyn.identification.arm.robot import Robot
from exidyn.identification.dynamics.dynamics import Dynamics, stacked
from exidyn.identification.effects import EFFECTS, Payload, RigidBody, RotorInertia
from exidyn.identification.effects.joint_state import JointState
from exidyn.identification.effects.rigid_body import inertial_parameters, moved
from exidyn.identification.model import Model

from ...parts.runs.robots import body, kinematics, placement, random_motion, six_axis, sliding
from ..effects.test_effects import default


def state_of(motion):
    """State of all samples, one array (t,) per joint and quantity."""
    parts = (motion.position, motion.velocity, motion.acceleration, motion.load, motion.temperature)
    return JointState(*(list(part.T) for part in parts))


WITHOUT_FORM = {"hysteresis", "torque_curve"}
"""Effects that have memory, or pieces."""


@pytest.fixture(params=[six_axis, sliding], ids=["six axis", "sliding"])
def robot(request):
    return request.param()


def values_of(model, seed=1):
    return np.random.default_rng(seed).normal(size=len(model.parameters))


@pytest.mark.parametrize("key", EFFECTS)
def test_every_effect_has_the_torque_of_its_regressor(key, robot):
    effects = {"link_inertia": RigidBody(), key: default(key)}
    model, motion = Model(robot, tuple(effects.values())), random_motion(robot, payload="L")
    values = values_of(model)
    dynamics = Dynamics.of(model, values, "L")
    expected = model.torque(model.loaded(motion), values)
    for effect, share in dynamics.left_out:
        expected = expected - effect.regressor(robot, motion) @ share
    torque = stacked(dynamics.torque(state_of(motion)), len(motion))
    np.testing.assert_allclose(torque, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())
    assert bool(dynamics.left_out) == (key in WITHOUT_FORM)


def test_a_known_payload_is_part_of_the_last_link(robot):
    known = tuple(zip(INERTIAL, inertial_parameters(body(np.random.default_rng(4))), strict=True))
    model, motion = Model(robot, (RigidBody(), Payload("L", known))), random_motion(robot, payload="L")
    values = values_of(model)
    for payload in ("L", ""):
        expected = model.torque(random_motion(robot, payload=payload), values)
        torque = Dynamics.of(model, values, payload).torque(state_of(motion))
        np.testing.assert_allclose(stacked(torque, len(motion)), expected, rtol=1e-12, atol=1e-9)


def test_friction_and_gravity_are_parts_of_the_torque(robot):
    keys = ("link_inertia", "viscous_friction", "load_dependent_friction", "current_offset", "joint_spring")
    model, motion = Model(robot, tuple(default(key) for key in keys)), random_motion(robot)
    dynamics = Dynamics.of(model, values_of(model))
    state = state_of(motion)
    still = state._replace(velocity=[0.0] * robot.dof, acceleration=[0.0] * robot.dof)
    held = stacked(dynamics.gravity_torque(state), len(motion))
    np.testing.assert_array_equal(held, stacked(dynamics.torque(still), len(motion)))
    assert np.all(np.array(dynamics.friction_torque(still)) == 0.0)
    steady = state._replace(acceleration=[0.0] * robot.dof)
    links = stacked(dynamics.link_torque(steady), len(motion)) - stacked(
        dynamics.link_torque(still), len(motion)
    )
    parts = held + links + stacked(dynamics.friction_torque(state), len(motion))
    np.testing.assert_allclose(parts, stacked(dynamics.torque(steady), len(motion)), atol=1e-9)


def test_moving_a_body_to_another_frame_agrees_with_pinocchio():
    random = np.random.default_rng(2)
    frame, inertia = placement(random), body(random)
    np.testing.assert_allclose(
        moved(inertial_parameters(inertia), frame),
        inertial_parameters(frame.act(inertia)),
        rtol=1e-12,
        atol=1e-12,
    )


@pytest.mark.parametrize("tree", ["rrrrrr", "pprrrp", "branched"])
def test_momentum_agrees_with_mass_and_coriolis_matrices(tree):
    branched = {"joints": "rrprrr", "parents": [0, 1, 2, 1, 4, 4]}
    model = kinematics(**branched) if tree == "branched" else kinematics(tree)
    robot = Robot("any", model)
    effects = Model(robot, (RigidBody(), RotorInertia()))
    values = effects.nominal_values
    rotors = values[-robot.dof :] = np.linspace(0.1, 1.0, robot.dof)
    dynamics, data, random = Dynamics.of(effects, values), model.createData(), np.random.default_rng(3)
    for _ in range(5):
        q, dq = random.normal(size=(2, robot.dof))
        zeros = [0.0] * robot.dof
        momentum, change = dynamics.momentum(JointState(q.tolist(), dq.tolist(), zeros, zeros, zeros))
        upper = np.triu(pin.crba(model, data, q))
        mass = upper + np.triu(upper, 1).T + np.diag(rotors)
        np.testing.assert_allclose(momentum, mass @ dq, rtol=1e-11, atol=1e-11)
        coriolis = pin.computeCoriolisMatrix(model, data, q, dq)
        np.testing.assert_allclose(change, coriolis.T @ dq, rtol=1e-10, atol=1e-10)
