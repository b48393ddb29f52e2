"""The plant moves by the laws of mechanics."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from parts.concealed.plant.body import inverse_dynamics, turn, weld
from parts.concealed.plant.closed_loop import EVERY, RATE, SETTLE, STEP, run
from parts.concealed.plant.forces import windup
from parts.concealed.plant.friction import add_friction, plain_friction
from parts.concealed.plant.mass import mass_matrix, solve
from parts.concealed.recordings.write import urdf
from parts.concealed.robots.arms import ARMS, EARTH

from .robots import quiet, small_arm, sound, sticking, swing

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", ARMS)
def test_bodies_move_as_pinocchio_predicts(name):
    robot = sound(name)
    body, n = robot.machine.body, robot.arm.joints
    model = pin.buildModelFromXML(urdf(replace(robot, prior=robot.prior._replace(body=body))))
    data = model.createData()
    position, velocity, acceleration = np.random.default_rng(1).normal(size=(3, n))
    turned, matrix, torque, found = np.empty((n, 3, 3)), np.empty((n, n)), np.empty(n), np.empty(n)
    turn(body.rotation, position, turned)
    inverse_dynamics(body, turned, velocity, acceleration, -EARTH, np.zeros(3), torque)
    expected = pin.rnea(model, data, position, velocity, acceleration)
    np.testing.assert_allclose(torque, expected, atol=1e-8 * np.max(np.abs(expected)))
    mass_matrix(body, turned, matrix)
    crba = pin.crba(model, data, position)
    np.testing.assert_allclose(matrix, np.triu(crba) + np.triu(crba, 1).T, atol=1e-8 * np.max(crba))
    inertia = matrix.copy()
    solve(matrix, torque, found)
    np.testing.assert_allclose(inertia @ found, torque)


def test_a_force_on_the_flange_is_felt_through_the_jacobian():
    robot = sound("ur10like")
    body, n = robot.machine.body, 6
    model = pin.buildModelFromXML(urdf(replace(robot, prior=robot.prior._replace(body=body))))
    position, force = np.random.default_rng(2).normal(size=n), np.array([3.0, -5.0, 7.0])
    turned, felt, free = np.empty((n, 3, 3)), np.empty(n), np.empty(n)
    turn(body.rotation, position, turned)
    for pull, torque in ((force, felt), (np.zeros(3), free)):
        inverse_dynamics(body, turned, np.zeros(n), np.zeros(n), -EARTH, pull, torque)
    jacobian = pin.computeJointJacobian(model, model.createData(), position, n)
    np.testing.assert_allclose(felt - free, -(jacobian[:3].T @ force), atol=1e-9)


def test_a_welded_body_keeps_mass_and_moments():
    body = small_arm(1).body
    heavier = weld(body, 0, 2.0, np.array([0.0, 0.3, 0.0]), 0.01 * np.eye(3))
    back = weld(heavier, 0, -2.0, np.array([0.0, 0.3, 0.0]), -0.01 * np.eye(3))
    assert heavier.mass[0] == 6.0
    np.testing.assert_allclose(back.com, body.com, atol=1e-12)
    np.testing.assert_allclose(back.inertia, body.inertia, atol=1e-12)


def test_without_an_effect_currents_are_inverse_dynamics():
    robot = sticking(small_arm())
    path = swing(2, 0.8)
    fine = robot.machine._replace(count=np.full(2, 1e-9))  # else drives chatter between two counts
    log = run(fine, path, quiet(path), np.full(2, 35.0))
    model = pin.buildModelFromXML(urdf(replace(robot, prior=robot.prior._replace(body=robot.machine.body))))
    data, friction = model.createData(), robot.machine.friction
    velocity = np.gradient(log.link, 1 / RATE, axis=0)
    acceleration = np.gradient(velocity, 1 / RATE, axis=0)
    rigid = np.array(
        [pin.rnea(model, data, *state) for state in zip(log.link, velocity, acceleration, strict=True)]
    )
    expected = rigid + acceleration * np.diag(robot.machine.rotor) - robot.machine.offset
    warmed = np.exp(-friction.thinning * (log.temperature - 35.0))
    expected += velocity * np.diag(friction.viscous) * warmed + np.sign(velocity) * friction.coulomb
    sliding = np.abs(velocity) > 0.2
    sliding[:20] = sliding[-20:] = False
    assert np.sqrt(np.mean((log.command - expected)[sliding] ** 2)) < 0.25 * robot.arm.floor[0]
    assert np.ptp(log.command) > 100 * robot.arm.floor[0]


def test_two_masses_keep_energy_and_momentum():
    robot = sticking(small_arm(1))
    free = robot.machine._replace(
        body=robot.machine.body._replace(gravity=np.zeros(3)),
        friction=plain_friction(np.zeros(1), np.zeros(1), np.full(1, 1e-5), np.zeros(1), np.ones(1)),
        stiffness=np.array([900.0]), offset=np.zeros(1), push=np.zeros((1, 4)),
    )  # fmt: skip
    path = np.zeros((3, 1000, 1))
    kick = quiet(path)
    start = round(SETTLE / STEP)
    kick[start : start + 100] = 30.0  # 1.5 N m s
    log = run(free, path, kick, np.full(1, 35.0))
    turned, link = np.empty((1, 3, 3)), np.empty((1, 1))
    turn(free.body.rotation, np.zeros(1), turned)
    mass_matrix(free.body, turned, link)
    # Central differences of samples that leap-frog: exact momentum, energy to the order of the step squared.
    spin, speed = (np.gradient(x, 1 / RATE, axis=0)[60:-5, 0] for x in (log.position, log.link))
    twist = (log.position - log.link)[60:-5, 0]
    momentum = spin * free.rotor[0, 0] + speed * link[0, 0]
    np.testing.assert_allclose(momentum, 1.5, rtol=1e-6)
    kinetic = 0.5 * (spin**2 * free.rotor[0, 0] + speed**2 * link[0, 0])
    energy = kinetic + 450.0 * twist**2
    np.testing.assert_allclose(energy, np.mean(energy), rtol=0.02)
    assert np.ptp(kinetic) > 0.1 * np.mean(energy)  # it does swing


def test_what_hangs_on_the_link_winds_the_transmission_up():
    robot = sticking(small_arm(1))
    soft = robot.machine._replace(stiffness=np.array([2000.0]), loss=np.array([60.0]), offset=np.zeros(1))
    tied = soft._replace(cable=np.array([[30.0, 0.0, -0.2]]))
    path = np.zeros((3, 200, 1))
    twist = [np.subtract(*run(one, path, quiet(path), np.full(1, 35.0))[:2])[-1, 0] for one in (soft, tied)]
    assert 2000.0 * (twist[1] - twist[0]) == pytest.approx(30.0 * 0.2, rel=0.05)


def test_a_dead_zone_passes_no_torque_and_then_a_spring():
    machine = sticking(small_arm(1)).machine._replace(gap=np.array([0.002]), stiffness=np.array([1e4]))
    assert windup(machine, 0, 0.0019, 5.0) == 0.0
    assert windup(machine, 0, 0.003, 0.0) == pytest.approx(10.0)
    assert windup(machine, 0, -0.003, 0.0) == pytest.approx(-10.0)
    path = swing(1, 0.6)
    loose = machine._replace(stiffness=np.array([2e4]), loss=np.array([20.0]))
    twist = np.subtract(*run(loose, path, quiet(path), np.full(1, 35.0))[:2])
    assert np.max(twist) > 0.002  # the motor leans on either side of its teeth
    assert np.min(twist) > -0.01


def test_bristles_give_way_at_dry_friction_and_hold_before():
    robot = sticking(small_arm(1))
    friction, torque = robot.machine.friction, np.zeros(1)
    bristles, blocks, still = np.zeros(2), np.zeros((1, 4)), np.zeros(1)
    for _ in range(400):
        add_friction(
            friction, still, np.array([0.2]), still, np.full(1, 35.0), bristles, blocks, STEP, torque
        )
    assert torque[0] == pytest.approx(friction.coulomb[0] + 0.2 * friction.viscous[0, 0], rel=1e-3)
    add_friction(friction, still, still, still, np.full(1, 35.0), bristles, blocks, STEP, torque)
    assert torque[0] == pytest.approx(friction.coulomb[0], rel=1e-3)


def test_a_drive_holds_a_sticking_arm_without_hunting():
    robot = sticking(small_arm(1))
    path = np.zeros((3, 400, 1))
    log = run(robot.machine, path, quiet(path), np.full(1, 35.0))
    assert np.ptp(log.command[50:], axis=0).max() < 0.1 * robot.arm.floor[0]


def test_samples_are_taken_every_fourth_step():
    assert pytest.approx(1.0) == STEP * EVERY * RATE
