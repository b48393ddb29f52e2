"""A plant that is pushed moves by the torque of its motors alone; position control takes it over smoothly."""

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.effects import RigidBody, RotorInertia
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.plant import typical_plant

TICK = 0.002
START = np.array([0.2, -0.9, 1.1, -0.4, 0.5, 0.3])


def bodies_and_rotors():
    """The cobot without friction, and its rotor inertias."""
    nominal = read_model("cobot")
    model = Model(nominal.robot, (RigidBody(), RotorInertia()), nominal.stated)
    rotors = [
        value for name, value in zip(model.names, model.nominal_values, strict=True) if name[:2] == "Ia"
    ]
    return model, np.array(rotors)


def test_a_push_accelerates_as_pinocchio_says():
    model, rotors = bodies_and_rotors()
    plant, kinematics = typical_plant(model, START), model.robot.kinematics
    data = kinematics.createData()
    position = plant.truth().position[0]
    gravity = pin.rnea(kinematics, data, position, np.zeros(6), np.zeros(6))
    push = np.array([10.0, -8.0, 6.0, 2.0, -1.0, 0.5])
    plant.push(gravity + push, TICK)
    inertia = pin.crba(kinematics, data, position)
    inertia = np.triu(inertia) + np.triu(inertia, 1).T + np.diag(rotors)
    np.testing.assert_allclose(
        plant.truth().velocity[0], TICK * np.linalg.solve(inertia, push), rtol=0.02, atol=1e-6
    )


def test_gravity_alone_holds_the_arm_and_position_control_takes_it_over_without_a_jump():
    model, _ = bodies_and_rotors()
    plant, kinematics = typical_plant(model, START), model.robot.kinematics
    data, still = kinematics.createData(), np.zeros(6)
    start = plant.truth().position[0]
    for _ in range(500):
        plant.push(pin.rnea(kinematics, data, plant.truth().position[0], still, still), TICK)
    floated = plant.truth().position[0]
    np.testing.assert_allclose(floated, start, atol=2e-4)
    for _ in range(100):
        plant.step(floated, still, TICK)
        np.testing.assert_allclose(plant.truth().position[0], floated, atol=1e-4)


def test_an_arm_that_is_caught_in_motion_stops_where_it_is_told():
    model, _ = bodies_and_rotors()
    plant, kinematics = typical_plant(model, START), model.robot.kinematics
    data, still = kinematics.createData(), np.zeros(6)
    for _ in range(50):
        gravity = pin.rnea(kinematics, data, plant.truth().position[0], still, still)
        plant.push(gravity + np.array([20.0, 0.0, 0.0, 0.0, 0.0, 0.0]), TICK)
    caught = plant.truth().position[0]
    assert plant.truth().velocity[0, 0] > 0.1
    for _ in range(1000):
        plant.step(caught, still, TICK)
    np.testing.assert_allclose(plant.truth().position[0], caught, atol=1e-4)


def test_released_motors_make_no_torque():
    model, _ = bodies_and_rotors()
    plant = typical_plant(model, START)
    plant.release()
    for _ in range(50):
        plant.push(np.full(6, 100.0), TICK)
    assert plant.truth().velocity[0, 1] * 1.0 != pytest.approx(0.0, abs=0.05)  # it drops
    np.testing.assert_allclose(plant.measure().current, 0.0, atol=0.05)
