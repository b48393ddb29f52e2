"""What a fit must not claim: unstated units, impossible values, runs that prove nothing."""

from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.document.text import section_markdown
from exidyn.identification.errors import DifferentRobot, RecordingError
from exidyn.identification.fit.equations import Equations, assemble
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import fit_text, read_fit
from exidyn.identification.fit.fit_warnings import FACTOR, far_gains, impossible_values, repeated_runs
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.verdict import JointState, joint_verdicts, payload_centres, verdict
from exidyn.identification.pages.fit_document import fit_document, report_html
from exidyn.identification.preparation.prepare import Filtering, choose, prepare
from exidyn.identification.recordings.recording import KnownPayload, Recording

from ...parts.small import two_joints
from ...parts.small.small_fit import fit, plain_fit, summary
from ...parts.small.two_joint_files import loaded, run

pytestmark = pytest.mark.numerical

SCALE = "currents were recorded and no drive gain is known: every value is per N m/A of its joint"


def silent(recording: Recording) -> Recording:
    """The recording, of a robot whose description contains no drives."""
    return replace(recording, model=two_joints.model(gain=np.ones(2)))


def equations(fitted: Fit) -> Equations:
    """Equations of the run without payload, for the parameters of a fit."""
    prepared = prepare(replace(run("empty"), model=fitted.model), fitted.filtering)
    return assemble(fitted.model, fitted.base, [prepared])


@cache
def amperes() -> Fit:
    return identify([silent(run("empty"))])


@cache
def found() -> Fit:
    """Unstated gains, found with a known payload."""
    return identify([silent(run("empty")), silent(loaded(KnownPayload("L", two_joints.MASS)))])


def test_amperes_are_not_called_newton_metres():
    assert amperes().measures == "current"
    assert verdict(amperes())[0].startswith(SCALE)
    [proposal] = [warning for warning in amperes().warnings if "gains by the described masses" in warning]
    assert all(joint in proposal for joint in amperes().model.robot.joints)
    assert [warning for warning in amperes().warnings if warning.startswith(SCALE)] == [verdict(amperes())[0]]
    assert len(set(verdict(amperes()))) == len(verdict(amperes()))
    text, page = summary(amperes()), report_html(amperes())
    for written in (text, page, "".join(map(section_markdown, fit_document(amperes()).sections))):
        assert "aken as measured" not in written
        assert "N m/A" in written
    rows = [line.split() for line in text.splitlines() if line.endswith(" other")]
    assert all(row[-2] == "A" for row in rows)
    assert "[A]" in page
    assert "[N m]" not in page
    assert "unit/(N m/A)" in page
    assert max(map(len, text.splitlines())) <= 110
    # The shoulder feels the forearm in other amperes than the elbow does: no physics has to be missing.
    assert "The unknown drive gains alone could cause this" in verdict(amperes())[1]
    *_, row = [line.split() for line in text.splitlines() if line.split()[:1] == ["MX2"]]
    assert np.isfinite(amperes().prior[1][amperes().names.index("MX2")])
    assert row[-2:] == ["-", "-"]


def test_gains_not_given_are_not_compared_with_one():
    np.testing.assert_allclose(found().estimate.gain, two_joints.GAIN, rtol=0.01)
    assert not any(SCALE in line for line in verdict(found()))
    gains = summary(found()).partition("\nDrive gains\n")[2].partition("\nParameters\n")[0]
    assert "1.000" not in gains
    assert far_gains(found()) == ()
    assert "off nominal" in summary(fit())
    row = next(line for line in gains.splitlines() if line.startswith("elbow"))
    assert row.split()[-3:] == ["-", "-", "-"]


@pytest.mark.parametrize("which", [amperes, plain_fit])
def test_what_was_recorded_is_in_the_file(which, tmp_path):
    path = tmp_path / "fit.json"
    path.write_text(fit_text(which()))
    assert read_fit(path).measures == "current"


def with_agreement(residual: float, noise_source: str = "rest") -> Fit:
    """A fit whose shoulder leaves this share of its torque's variation, at the noise."""
    of = fit().validation[0]
    measured = of.measured - np.sum(of.measured * of.weight, axis=0) / of.weight.sum(axis=0)
    predicted = measured * [1.0 - residual, 0.99]
    run = replace(of, measured=measured, predicted=predicted, noise_source=noise_source)
    return replace(fit(), validation=(replace(run, noise=run.residual_rms),))


def test_noise_explained_by_noise_is_no_explanation():
    states = [[v.state for v in joint_verdicts(with_agreement(share))] for share in (0.51, 0.49)]
    assert states == [[JointState.UNTESTED, JointState.EXPLAINED], [JointState.EXPLAINED] * 2]
    first = verdict(with_agreement(0.51))[0]
    assert "The residual of 1 of 2 joints is at the noise floor" in first
    assert "Not distinguished from noise on shoulder (1.0 x noise): the motion moves it too little" in first
    both = (*with_agreement(0.51).validation, *with_agreement(0.2).validation)
    assert [v.words for v in joint_verdicts(replace(fit(), validation=both))] == ["at the noise floor"] * 2
    guess = "The noise floor is a guess from high frequencies, a lower bound"
    assert any(line.startswith(guess) for line in verdict(with_agreement(0.2, "high frequencies")))
    assert not any(line.startswith(guess) for line in verdict(with_agreement(0.2)))


def test_the_same_recording_is_known_by_its_content():
    a, b = run("a"), run("b", 2, 3)
    [twice] = repeated_runs([a, b, replace(a, name="copy")], [])
    assert twice.startswith("a and copy are the same recording, used twice")
    [held_out] = repeated_runs([a], [b, replace(a, name="copy")])
    assert held_out == "copy: validation on a run that was also used (as a) proves nothing"
    assert "validated on twice" in repeated_runs([a], [b, replace(b, name="copy")])[0]
    assert repeated_runs([a], [b]) == ()
    current = a.signals["current"]
    heavier = replace(a, signals={**a.signals, "current": replace(current, values=2 * current.values)})
    assert repeated_runs([a, heavier], []) == ()


def renamed(recording: Recording) -> Recording:
    robot = recording.robot
    kinematics = robot.kinematics.copy()
    kinematics.names[1] = "base_axis"
    return replace(recording, model=replace(recording.model, robot=replace(robot, kinematics=kinematics)))


def test_a_robot_with_other_joints_is_refused_with_both_lists():
    model = renamed(run("empty")).model
    with pytest.raises(DifferentRobot, match=r"joints shoulder, elbow\), but .*joints base_axis, elbow\)"):
        identify([run("empty")], model=model)


@pytest.mark.parametrize(
    ("ratio", "warned"), [(1.01 * FACTOR, 1), (0.99 / FACTOR, 1), (-1.0, 1), (0.99 * FACTOR, 0)]
)
def test_gains_far_from_those_stated_point_to_the_mass(ratio, warned):
    gain = fit().model.robot.drive_gain * [1.0, ratio]
    warnings = far_gains(replace(fit(), estimate=replace(fit().estimate, gain=gain)))
    assert len(warnings) == warned
    assert all("elbow" in d and "check --mass (is its unit kg?" in d for d in warnings)


@pytest.mark.parametrize(("deviations", "warned"), [(-2.1, True), (-1.9, False), (5.0, False)])
def test_a_negative_friction_is_impossible(deviations, warned):
    values = np.array(plain_fit().estimate.values)
    values[plain_fit().names.index("Fv2")] = (
        deviations * plain_fit().estimate.std[plain_fit().names.index("Fv2")]
    )
    warnings = impossible_values(
        replace(plain_fit(), estimate=replace(plain_fit().estimate, values=values)), equations(plain_fit())
    )
    assert [d.startswith("Fv2 is negative (-0.") for d in warnings] == [True] * warned
    assert all("try --estimator consistent" in d for d in warnings)


def test_friction_below_zero_alone_is_no_wrong_sign():
    values = np.array(plain_fit().estimate.values)
    for name in ("Fc2", "Fv2"):
        values[plain_fit().names.index(name)] = -100 * plain_fit().estimate.std[plain_fit().names.index(name)]
    negative = replace(plain_fit(), estimate=replace(plain_fit().estimate, values=values))
    warnings = impossible_values(negative, equations(plain_fit()))
    assert [warning.partition(" ")[0] for warning in warnings] == ["Fv2", "Fc2"]
    assert not any("reverse" in warning for warning in warnings)


@pytest.mark.parametrize("joints", [[0], [1], [0, 1]])
def test_a_sign_is_advised_if_the_reversed_torque_fits_as_well(joints):
    recording = run("empty")
    [name] = {"current", "torque"} & set(recording.signals)
    signal, sign = recording.signals[name], np.ones(2)
    sign[joints] = -1.0
    turned = replace(signal, values=sign * signal.values)
    wrong = identify([replace(recording, signals={**recording.signals, name: turned})], as_recorded=True)
    advised = [warning for warning in wrong.warnings if "its sign is wrong" in warning]
    for joint, robot_joint in enumerate(recording.robot.joints):
        assert any(robot_joint in warning for warning in advised) == (joint in joints)


def test_a_tilted_base_is_no_wrong_sign():
    """Gravity in another direction spoils friction and rotor inertia, and no reversal repairs them."""
    recording = run("empty")
    for tilt in np.radians([20.0, 45.0, 70.0]):
        kinematics = recording.robot.kinematics.copy()
        kinematics.gravity = pin.Motion(9.81 * np.array([np.sin(tilt), 0.0, -np.cos(tilt)]), np.zeros(3))
        model = replace(recording.model, robot=replace(recording.robot, kinematics=kinematics))
        tilted = identify([recording], model=model, as_recorded=True)
        assert not any("its sign is wrong" in warning for warning in tilted.warnings)


def test_regrouped_values_may_be_negative():
    values = -1e3 * np.abs(plain_fit().estimate.values)
    warnings = impossible_values(
        replace(plain_fit(), estimate=replace(plain_fit().estimate, values=values)), equations(plain_fit())
    )
    names = {word.strip(",") for warning in warnings for word in warning.split()}
    named = names & set(plain_fit().names)
    assert {"Fv1", "Fc2"} <= named
    assert not [name for name in named if name.startswith(("M", "Off")) or name.endswith("R")]


def test_the_payload_has_its_centre_of_mass():
    [words] = payload_centres(fit())
    assert words in " ".join(summary(fit()).split())
    x = float(words.partition(": x ")[2].split()[0])
    z = float(words.partition(", z ")[2].split()[0])
    assert (x, z) == pytest.approx((0.1, 0.05), abs=0.003)  # MXL and MZL of two_joints, over 3 kg
    half = float(words.partition(": x ")[2].split()[2].rstrip(","))
    assert half == pytest.approx(1.96 * fit().estimate.std[fit().names.index("MXL")] / 3.0, rel=0.05)
    assert payload_centres(plain_fit()) == []


@pytest.mark.parametrize(("option", "value"), [("position_cutoff", 125.0), ("torque_cutoff", 1e4)])
def test_cutoffs_that_no_filter_has_are_refused(option, value):
    with pytest.raises(RecordingError, match=rf"--{option.replace('_', '-')} is {value:g} Hz; .* 125 Hz"):
        choose(run("empty"), Filtering(**{option: value}))
    assert choose(run("empty"), Filtering(position_cutoff=124.0)).position_cutoff == 124.0


@pytest.mark.parametrize("option", ["position_cutoff", "torque_cutoff", "standstill"])
@pytest.mark.parametrize("value", [0.0, -3.0, np.nan])
def test_filters_are_above_zero(option, value):
    with pytest.raises(RecordingError, match=rf"--{option.replace('_', '-')} is {value:g} .*must be above 0"):
        Filtering(**{option: value})


def test_a_standstill_above_every_speed_is_refused():
    with pytest.raises(
        RecordingError, match=r"--standstill is 100 rad/s; .*highest speed of any joint in empty"
    ):
        identify([run("empty")], filtering=Filtering(standstill=100.0))
