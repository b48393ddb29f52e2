"""A base that leans: which way is which, and how far."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.diagnosis.candidates import hypotheses
from exidyn.identification.diagnosis.candidates.base_tilt import tilts
from exidyn.identification.diagnosis.candidates.bodies import with_found
from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.improved.improved import as_found
from exidyn.identification.diagnosis.words.sentences import sentence
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording

from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import names, record, searched, sound_problem

pytestmark = pytest.mark.slow


def leaning(model: Model, x: float, y: float) -> Model:
    """The model with gravity that has a part along the base's axes."""
    down = model.robot.gravity
    return under(model, down + np.linalg.norm(down) * np.array([x, y, 0.0]))


def under(model: Model, field: np.ndarray) -> Model:
    """The model in another field of gravity [m/s^2]."""
    kinematics = model.robot.kinematics.copy()
    kinematics.gravity = pin.Motion(field, np.zeros(3))
    return replace(model, robot=replace(model.robot, kinematics=kinematics))


def runs_of(plant: Model, nominal: Model) -> list[tuple[str, Recording]]:
    """Runs of an arm that is mounted otherwise than its model."""
    upright = nominal.robot.kinematics
    return [
        (role, replace(run, model=replace(run.model, robot=replace(run.model.robot, kinematics=upright))))
        for role, run in record(model=plant)
    ]


def test_columns_are_what_gravity_adds_along_each_axis():
    at = sound_problem()
    run = at.runs[0]
    [candidate] = tilts(at.model)
    columns = candidate.columns(run)
    assert candidate.names == ("tilt_x", "tilt_y")
    values = at.model.nominal_values
    for place, lean in enumerate(((1e-3, 0.0), (0.0, 1e-3))):
        turned = leaning(at.model, *lean)
        more = turned.torque(run.motion, values) - at.model.torque(run.motion, values)
        np.testing.assert_allclose(columns[:, :, place], more / 1e-3, atol=1e-6)
    # Both joints turn about the base's y axis.
    assert np.max(np.abs(columns[:, :, 0])) > 10.0
    assert np.max(np.abs(columns[:, :, 1])) < 1e-9


def test_a_payload_that_was_found_leans_with_the_base():
    at = sound_problem()
    run, robot, lean = at.runs[0], at.model.robot, 1e-3
    [payload] = hypotheses("payload", at.model)
    values = np.array([3.0, 0.6, 0.0, 0.3, 0.2, 0.0, 0.0, 0.2, 0.0, 0.2])
    loaded = replace(run, found=with_found(run.bodies, robot, payload, values))
    [candidate] = tilts(at.model)
    more = (candidate.columns(loaded) - candidate.columns(run))[:, :, 0]
    [turned] = hypotheses("payload", leaning(at.model, lean, 0.0))
    np.testing.assert_allclose(more, (turned.columns(run) - payload.columns(run)) @ values / lean, atol=1e-6)
    assert np.max(np.abs(more)) > 1.0


def test_a_base_that_leans_is_reported_with_its_angle():
    stated = nominal_model()
    found = searched(runs_of(leaning(stated, 0.03, 0.0), stated))
    # All joints of this arm turn about one direction: the first one's zero leans it as well.
    [one] = found.selected
    every = {other.candidate.key[:2]: other for other in (one.answer, *(other for other, _ in one.others))}
    assert set(names(found)) <= {("base_tilt", ()), ("encoder_offset", (0,))}
    tilt, zero = every["base_tilt", ()], every["encoder_offset", (0,)]
    assert abs(tilt.values[0] - 0.03) < 2e-3
    assert abs(abs(zero.values[0]) - 0.03) < 2e-3


def test_an_arm_that_is_mounted_otherwise_is_found_with_the_direction_of_gravity():
    angle = 130.0
    stated, turn = nominal_model(), np.deg2rad(angle)
    field = 9.81 * np.array([np.sin(turn), 0.0, -np.cos(turn)])
    runs = runs_of(under(stated, field), stated)
    found = diagnose(stated, runs)
    [one] = found.findings
    assert (one.effect, one.joints) == ("base_tilt", ())
    lean = one.parameters["lean"]
    assert abs(np.rad2deg(lean.value) - angle) < 1.0
    assert 0.0 < np.rad2deg(lean.std) < 1.0
    assert abs(one.parameters["gravity_x"].value - np.sin(turn)) < 0.02
    # Noise at rest is known to some thirty per cent.
    assert np.all(found.torque_rms_after < 1.4 * found.noise)
    turned = as_found(found.evidence, found.findings).model.robot.gravity
    # Nothing along y is seen by joints that turn about it.
    np.testing.assert_allclose(turned[[0, 2]], field[[0, 2]], atol=0.2)
    text = sentence(one, stated.robot.joints)
    assert text.startswith("The base is not level: it leans by ")
    assert "gravity points along" in text
    assert "gravity has" not in text


@pytest.mark.long
def test_a_share_of_the_weight_that_something_else_carries_is_found():
    stated = nominal_model()
    found = diagnose(stated, runs_of(under(stated, 0.4 * stated.robot.gravity), stated))
    [one] = found.findings
    assert (one.effect, one.joints) == ("gravity_compensation", ())
    assert abs(one.parameters["compensated"].value - 0.6) < 0.03
    lighter = as_found(found.evidence, found.findings).model.robot.gravity
    np.testing.assert_allclose(lighter, 0.4 * stated.robot.gravity, atol=0.3)
    assert "60" in sentence(one, stated.robot.joints)
