"""Recordings of a motion that a plant follows exactly, and arms as built."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.effects import LoadDependentFriction, Payload, RigidBody, known_parameters
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.recordings.recording_checks import check
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import MOST, Sensors, as_built, exact_current, simulate

from ...parts.runs.robots import random_motion, six_axis
from ...parts.small.two_joints import GAIN, MASS, model, trajectory, true_values

EXACT = Sensors(current_noise=0.0, encoder_noise=0.0, encoder_step=0.0)


@pytest.fixture(scope="module")
def motion():
    return trajectory(10.0).at(np.arange(0.0, 10.0, 0.002))


def record(motion, sensors=EXACT, **options):
    return simulate(model(), true_values(model()), GAIN, motion, model(), sensors, **options)


def test_current_is_inverse_dynamics_over_gain(motion):
    of = Model(model().robot, (RigidBody(),))
    current = exact_current(of, of.nominal_values, GAIN, motion)
    data = of.robot.kinematics.createData()
    for row in range(0, len(motion), 499):
        torque = pin.rnea(
            of.robot.kinematics, data, motion.position[row], motion.velocity[row], motion.acceleration[row]
        )
        np.testing.assert_allclose(current[row], torque / GAIN, rtol=1e-9, atol=1e-12)


def test_pieces_make_the_whole(motion):
    """Longer than a piece, with friction that depends on nominal load."""
    of = model() + LoadDependentFriction()
    values = np.append(true_values(model()), [0.02, 0.03])
    whole = of.torque(of.loaded(motion), values) / GAIN
    assert len(motion) > 4000
    np.testing.assert_allclose(exact_current(of, values, GAIN, motion), whole, rtol=1e-12, atol=1e-12)


def test_motors_of_coupled_joints_do_the_same_work():
    robot = six_axis()
    of = Model(robot, (RigidBody(),))
    motion = random_motion(robot)
    current = exact_current(of, of.nominal_values, np.arange(1.0, 7.0), motion)
    motors = np.sum(current * np.arange(1.0, 7.0) * (motion.velocity @ robot.coupling.T), axis=1)
    np.testing.assert_allclose(
        motors, np.sum(of.torque(motion, of.nominal_values) * motion.velocity, axis=1), atol=1e-9
    )


def test_sensors_add_noise_and_steps_or_nothing(motion):
    recording = record(motion)
    np.testing.assert_array_equal(recording.signals["position"].values, motion.position)
    np.testing.assert_array_equal(recording.signals["command"].values, motion.position)
    np.testing.assert_allclose(recording.signals["position"].time, motion.time, atol=1e-9)
    assert not check(recording).warnings
    exact = record(motion)
    noisy = record(motion, Sensors(current_noise=0.05, encoder_noise=1e-4, encoder_step=0.0))
    difference = {
        k: noisy.signals[k].values - exact.signals[k].values for k in ("current", "position", "command")
    }
    usual = np.sqrt(np.mean(exact.signals["current"].values ** 2, axis=0))
    np.testing.assert_allclose(np.std(difference["current"], axis=0), 0.05 * usual, rtol=0.05)
    np.testing.assert_allclose(np.std(difference["position"], axis=0), 1e-4, rtol=0.05)
    assert not np.any(difference["command"])
    position = record(motion, replace(EXACT, encoder_step=1e-3)).signals["position"].values
    np.testing.assert_allclose(position / 1e-3, np.round(position / 1e-3), atol=1e-9)
    assert np.abs(position - motion.position).max() <= 0.5e-3 + 1e-12


def test_payload_hangs_on_the_arm_that_carries_it(motion):
    plant = model(Payload("L", MASS))
    values = true_values(plant, 3.0)
    runs = [
        simulate(plant, values, GAIN, motion, model(), EXACT, payload=payload)
        for payload in (None, KnownPayload("L", MASS))
    ]
    np.testing.assert_allclose(
        runs[0].signals["current"].values, record(motion).signals["current"].values, atol=1e-12
    )
    carried = replace(motion, payload="L")
    difference = GAIN * (runs[1].signals["current"].values - runs[0].signals["current"].values)
    expected = plant.torque(carried, values) - plant.torque(motion, values)
    np.testing.assert_allclose(difference, expected, atol=1e-9)
    assert np.abs(difference).max() > 5.0  # 3 kg at up to 0.7 m
    assert runs[1].payload == KnownPayload("L", MASS)


def masses(model):
    return np.array([body.mass for body in model.robot.kinematics.inertias[1:]])


def test_values_are_off_by_their_tolerance_with_and_without_a_payload():
    """An arm as built has other values than its nominal ones, within what is stated, and always the same."""
    nominal = read_model("cobot")
    built = as_built(nominal)
    for off in (
        built.robot.drive_gain / nominal.robot.drive_gain - 1,
        masses(built) / masses(nominal) - 1,
        np.array([built.stated[n].value / p.value - 1 for n, p in nominal.stated.items() if p.value]),
    ):
        assert np.all(off != 0.0)
        assert np.all(np.abs(off) <= MOST)
        assert len(set(off)) == len(off)
    alone, loaded = (as_built(one) for one in (nominal, nominal + Payload("L", known_parameters(8.0))))
    np.testing.assert_array_equal(alone.robot.drive_gain, loaded.robot.drive_gain)
    np.testing.assert_array_equal(masses(alone), masses(loaded))
    assert alone.stated == loaded.stated
