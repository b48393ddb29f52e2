"""An arm whose second joint has no motor: a pendulum at the end of a driven link."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.robot import Robot
from exidyn.identification.effects.rigid_body import RigidBody
from exidyn.identification.errors import NotRecorded, UnknownJoint
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.verdict import joint_verdicts, verdict
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording, Signal

RATE = 500.0


def arm(masses=(2.0, 0.5), **options):
    kinematics = pin.Model()
    for place, mass in enumerate(masses):
        offset = pin.SE3(np.eye(3), np.array([0.3 * place, 0.0, 0.0]))
        index = kinematics.addJoint(place, pin.JointModelRY(), offset, ("shoulder", "pendulum")[place])
        body = pin.Inertia(mass, np.array([0.15, 0.0, 0.02]), 0.01 * mass * np.eye(3))
        kinematics.appendBodyToJoint(index, body, pin.SE3.Identity())
    return Model(Robot("pendubot", kinematics, **options), (RigidBody(),))


def swinging(model, seconds=20.0, substeps=4):
    """Torque of the driven joint, position of both, by integration of the equations of motion."""
    data, rng = model.robot.kinematics.createData(), np.random.default_rng(1)
    rate, size = 2 * np.pi * np.array([0.4, 0.7, 1.1]), rng.normal(size=3)
    position, velocity = np.array([1.2, 0.8]), np.zeros(2)
    time = np.arange(int(seconds * RATE)) / RATE
    positions, torques = [], []
    for now in time:
        torque = np.array([4.0 * np.cos(rate * now) @ size - 1.5 * velocity[0], 0.0])
        positions.append(position.copy())
        torques.append(torque)
        for _ in range(substeps):  # the torque is held over a sample: a second-order step suffices
            half = velocity + 0.5 * pin.aba(model.robot.kinematics, data, position, velocity, torque) / (
                RATE * substeps
            )
            position = position + half / (RATE * substeps)
            velocity = half + 0.5 * pin.aba(model.robot.kinematics, data, position, half, torque) / (
                RATE * substeps
            )
    return time, np.array(positions), np.array(torques)


@pytest.fixture(scope="module")
def recorded():
    time, position, torque = swinging(arm())
    torque[:, 0] += 0.05 * np.random.default_rng(2).normal(size=len(time))
    position += 1e-5 * np.random.default_rng(3).normal(size=position.shape)
    return {"position": Signal(time, position), "torque": Signal(time, torque)}


def recording(signals, **options):
    return Recording("swing", arm((1.7, 0.6), **options), signals)


def test_its_equation_of_zero_torque_helps_to_identify_the_others(recorded):
    fit = identify([recording(recorded, passive=("pendulum",))])
    true = dict(zip(fit.names, fit.base.regrouping @ arm().nominal_values, strict=True))
    values = dict(zip(fit.names, fit.estimate.values, strict=True))
    assert {name: round(value, 2) for name, value in values.items()} == pytest.approx(true, abs=0.02)
    assert joint_verdicts(fit)[1].words == "no motor"
    assert any("Without a motor: pendulum." in sentence for sentence in verdict(fit))


def test_a_joint_of_which_nothing_is_stated_or_with_a_torque_is_refused(recorded):
    with pytest.raises(NotRecorded, match="pendulum is constant at 0.*passive"):
        identify([recording(recorded)])
    torque = replace(recorded["torque"], values=recorded["torque"].values + [0.0, 0.5])
    with pytest.raises(NotRecorded, match="pendulum is constant at 0.5"):
        identify([recording(recorded | {"torque": torque}, passive=("pendulum",))])
    with pytest.raises(UnknownJoint, match="elbow"):
        arm(passive=("elbow",))
