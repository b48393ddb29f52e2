"""A motor that also turns with a neighbour of its joint, so that its link is not at the recorded position."""

import sys
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.diagnosis.candidates import hypotheses
from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.findings.arm import Arm
from exidyn.identification.diagnosis.findings.finding import Finding
from exidyn.identification.diagnosis.findings.quantities import stated
from exidyn.identification.diagnosis.improved.improved import as_found, with_finding
from exidyn.identification.diagnosis.words.sentences import sentence
from exidyn.identification.quantity import Quantity
from exidyn.identification.simulation.plant import Transmission

from ...parts.small import two_joints
from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import record, sound_problem

pytestmark = pytest.mark.slow

KINEMATICS = two_joints.arm().kinematics


def links(motor, velocity, acceleration, coupling):
    """Torque of the motors (t, n) [N m], by virtual power and not by the inverse of a transposed matrix."""
    data, back = KINEMATICS.createData(), np.linalg.inv(coupling)
    joints = [(back @ q, back @ v, back @ a) for q, v, a in zip(motor, velocity, acceleration, strict=True)]
    return np.array([pin.rnea(KINEMATICS, data, *state) @ back for state in joints])


def coupled(coupling):
    """Runs whose positions are those of the motors."""

    def change(role, motion, current):
        state = motion.position, motion.velocity, motion.acceleration
        more = links(*state, coupling) - links(*state, np.eye(2))
        return current + more / two_joints.GAIN

    return record(change=change)


@pytest.mark.parametrize(("motor", "other", "ratio"), [(1, 0, 1.0), (0, 1, -0.5)])
def test_columns_are_what_links_elsewhere_ask_of_both_motors(motor, other, ratio):
    at = sound_problem()
    coupling = np.eye(2)
    coupling[motor, other] = ratio
    [candidate] = [
        one
        for one in hypotheses("kinematic_coupling", at.model)
        if one.shape.get("moved") == motor + 1 and one.shape["ratio"] == ratio
    ]
    motion = at.runs[0].motion
    state = motion.position, motion.velocity, motion.acceleration
    more = links(*state, coupling) - links(*state, np.eye(2))
    np.testing.assert_allclose(candidate.columns(at.runs[0])[:, :, 0], more, atol=1e-9)
    assert np.max(np.abs(more)) > 1.0


@pytest.mark.long
def test_a_link_that_is_not_where_its_motor_states_is_found_with_its_ratio():
    coupling = np.array([[1.0, 0.0], [0.8, 1.0]])
    found = diagnose(nominal_model(), coupled(coupling), "coupled")
    [finding] = found.findings
    assert (finding.effect, finding.joints) == ("kinematic_coupling", (0, 1))
    assert finding.parameters["ratio"].value == pytest.approx(0.8, abs=0.02)
    text = sentence(finding, found.joints)
    assert "the recorded position of joint 2 is that of its motor" in text
    assert not set("{}[]") & set(text)


MOTOR, OTHER, TURNS = 1, 0, 0.8
DRAG = {"Ia": 0.4, "Fv": 1.0, "Fc": 1.5}
"""Inertia, viscosity and dry friction of the shared motor, as its joint feels them."""


def by_motors(position, velocity, acceleration):
    """What the motors carry beyond the joints' torques, (t, n) [N m], by virtual power."""
    data, coupling = KINEMATICS.createData(), np.eye(2)
    coupling[MOTOR, OTHER] = TURNS

    def resists(speed, acceleration):
        return DRAG["Ia"] * acceleration + DRAG["Fv"] * speed + DRAG["Fc"] * np.tanh(speed / 0.003)

    states = zip(position, velocity, acceleration, strict=True)
    tau = np.array([pin.rnea(KINEMATICS, data, *state) for state in states])
    # The motors' power is that of the joints at any velocity: at each motor's alone it gives its torque.
    one_motor_turns = np.linalg.inv(coupling)
    more = tau @ one_motor_turns - tau
    turning = resists(velocity @ coupling.T, acceleration @ coupling.T) - resists(velocity, acceleration)
    more[:, MOTOR] += turning[:, MOTOR]
    return more


def test_columns_for_currents_of_the_motors_take_the_links_torque_from_the_other_motor():
    at = sound_problem()
    [candidate] = [
        one
        for one in hypotheses("kinematic_coupling", at.model)
        if one.shape.get("motor") == MOTOR + 1 and one.shape["ratio"] == 1.0
    ]
    candidate, run = candidate.reshaped({"ratio": TURNS}), at.runs[0]
    coefficients = np.array([1.0, TURNS * DRAG["Ia"], TURNS * DRAG["Fv"], DRAG["Fc"]])
    motion = run.motion
    np.testing.assert_allclose(
        candidate.columns(replace(run, motion=replace(motion, load=run.unloaded.of_links))) @ coefficients,
        by_motors(motion.position, motion.velocity, motion.acceleration),
        atol=1e-9,
    )


def test_an_arm_with_that_coupling_needs_the_torque_of_its_columns():
    at = sound_problem()
    run, model = at.runs[0].after(at.model, at.model.nominal_values), at.model
    [candidate] = [
        one
        for one in hypotheses("kinematic_coupling", model)
        if one.shape.get("motor") == MOTOR + 1 and one.shape["ratio"] == -1.0
    ]
    # The friction of its joint is that of the motor.
    own = dict(zip(model.names, model.nominal_values, strict=True))
    drag = [TURNS * own.get(f"Ia{MOTOR + 1}", 0.0), TURNS * own[f"Fv{MOTOR + 1}"], own[f"Fc{MOTOR + 1}"]]
    candidate, coefficients = candidate.reshaped({"ratio": -TURNS}), np.array([1.0, *drag])
    reported, _ = candidate.reported_as(coefficients, coefficients)
    numbers = dict(zip(candidate.names, reported, strict=True)) | dict(candidate.shape)
    parameters = {name: Quantity(value, 0.0, "") for name, value in numbers.items()}
    found = Finding(
        **stated(candidate), parameters=parameters, probability=1.0, torque_rms=np.ones(2), held_out=1.0
    )
    arm = Arm(model, model.nominal_values, two_joints.GAIN, Transmission.rigid(2))
    before, after = (
        one.model.torque(run.motion, one.values) @ one.model.robot.to_motors.T
        for one in (arm, with_finding(arm, found))
    )
    # At lower speed dry friction reverses over the velocity of the one motor or of the other.
    moves = np.all(np.abs(run.motion.velocity) > 0.03, axis=1)
    np.testing.assert_allclose(
        (after - before)[moves], (candidate.columns(run) @ coefficients)[moves], atol=1e-6
    )


def coupled_by_motors():
    def change(role, motion, current):
        return current + by_motors(motion.position, motion.velocity, motion.acceleration) / two_joints.GAIN

    return record(change=change)


@pytest.mark.long
@pytest.mark.parametrize("turns", [TURNS, 0.12])
def test_currents_of_coupled_motors_are_a_coupling_and_no_crosstalk(turns, monkeypatch):
    monkeypatch.setattr(sys.modules[__name__], "TURNS", turns)
    found = diagnose(nominal_model(), coupled_by_motors(), "coupled")
    [finding] = found.findings
    assert (finding.effect, finding.joints) == ("kinematic_coupling", (0, 1))
    assert finding.parameters["ratio"].value == pytest.approx(turns, abs=0.02)
    assert "the recorded currents are those of the motors" in sentence(finding, found.joints)
    # The arm that holds it needs as much current as was recorded.
    arm = as_found(found.evidence, found.findings)
    assert not arm.left_out
    np.testing.assert_allclose(arm.model.robot.coupling, [[1.0, 0.0], [turns, 1.0]], atol=0.02)
