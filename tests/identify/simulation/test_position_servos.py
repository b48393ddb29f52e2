"""Simulated arms whose drives are position servos."""

from dataclasses import replace

import numpy as np

from exidyn.identification.arm.robot import PositionServo
from exidyn.identification.simulation.plant import typical_plant

from ...parts.small import two_joints

STIFFNESS = np.array([400.0, 200.0])


def servo_arm(limit=np.inf):
    model = two_joints.model()
    servo = PositionServo(np.array([2.0, 1.0]), np.full(2, limit))
    return replace(model, robot=replace(model.robot, drive_gain=STIFFNESS / servo.gain, servo=servo))


def test_a_servo_gives_way_by_its_stiffness_up_to_its_limit():
    model, start = servo_arm(), np.array([0.3, -0.4])
    values = two_joints.true_values(model)
    plant = typical_plant(model, start, values)
    assert np.abs(plant.measure().position - start).max() < 1e-3
    for _ in range(400):
        plant.step(start, np.zeros(2), 0.01)
    truth = plant.truth()
    still = replace(truth, velocity=0.0 * truth.velocity, acceleration=0.0 * truth.acceleration)
    holding = model.torque(still, values)[0]
    dry = values[[model.names.index(name) for name in ("Fc1", "Fc2")]]
    asked = STIFFNESS * (start - truth.position[0])
    assert np.all(np.abs(holding) > 1.5 * dry)  # else nothing is shown
    assert np.all(np.abs(asked - holding) < 1.05 * dry)  # at rest anywhere within what friction holds
    plant = typical_plant(servo_arm(limit=0.02), np.zeros(2))
    for _ in range(20):
        plant.step(np.array([1.0, 1.0]), np.zeros(2), 0.01)
    np.testing.assert_allclose(np.abs(plant.measure().current), 0.02, rtol=0.05)
