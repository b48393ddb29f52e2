"""The arm with what was found in it, as a model, and fitted again."""

from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest

from exidyn.identification.diagnosis import Finding, Quantity
from exidyn.identification.diagnosis.candidates import KINDS, hypotheses
from exidyn.identification.diagnosis.candidates.backlash import plays
from exidyn.identification.diagnosis.candidates.joint_elasticity import gears
from exidyn.identification.diagnosis.findings.evidence import Evidence
from exidyn.identification.diagnosis.findings.quantities import stated
from exidyn.identification.diagnosis.improved.improved import as_found, as_nominal, found_model, rivals
from exidyn.identification.diagnosis.questions.candidate import Candidate
from exidyn.identification.diagnosis.refit import model_to_fit, refit
from exidyn.identification.diagnosis.runs.driven import Driven
from exidyn.identification.effects import JointSpring, Payload, Prior, SpringBalancer
from exidyn.identification.measurements import MEASUREMENTS, TimeDelay
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.recording import Signal
from exidyn.identification.robot_files.robot_file import parse_model
from exidyn.identification.robot_files.robot_text import model_text

from ...parts.small.small_diagnosis import STIFFNESS, diagnosis, nominal_model, recording, recordings

pytestmark = pytest.mark.slow

SMALL = 1e-4
"""Of every coefficient, so that what is not linear in it cannot be seen."""
OF_MEASUREMENT = ("drive_gain_saturation", "current_clipping", "time_delay")
BETWEEN = {"joint_elasticity": gears, "backlash": plays}
OUTSIDE = (
    "hose_spring supply_sag current_crosstalk neighbour_friction contact_event periodic_disturbance "
    "warming_friction"
).split()
HELD = [name for name in KINDS if name not in (*OF_MEASUREMENT, *BETWEEN, *OUTSIDE)]


@cache
def run() -> Driven:
    short = recording("identify", 0, length=6.0)
    warm = Signal(short.signals["position"].time, 25.0 + short.signals["position"].values)
    return Driven.of(
        nominal_model(),
        replace(short, signals={**short.signals, "temperature": warm}),
        "identify",
        Filtering(),
    )


def evidence() -> Evidence:
    model = nominal_model()
    values, gain = model.nominal_values, model.robot.drive_gain
    return Evidence(model, values, values, gain, gain, np.full(2, 0.1), ())


def found(candidate: Candidate, value: float = SMALL) -> Finding:
    numbers = {
        name: Quantity(value, np.nan, unit)
        for name, unit in zip(candidate.names, candidate.units, strict=True)
    }
    shape = {name: Quantity(number, np.nan, "") for name, number in candidate.shape.items()}
    return Finding(
        **stated(candidate), parameters=shape | numbers, probability=1.0, torque_rms=np.ones(2), held_out=1.0
    )


@pytest.mark.parametrize("effect", HELD)
def test_a_model_gives_the_torque_that_the_search_found(effect):
    # A link that stands elsewhere is no part of any model; motors that turn with two joints do so or not.
    asked = [one for one in hypotheses(effect, nominal_model()) if not {"moved", "motor"} & set(one.shape)]
    for candidate in asked[-2:]:
        one = found(candidate)
        before, after = as_nominal(evidence()), as_found(evidence(), [one])
        assert after.left_out == ()
        motion = run().motion
        shown = [
            arm.model.torque(motion, arm.values) * nominal_model().robot.drive_gain / arm.gain
            for arm in (before, after)
        ]
        expected = candidate.columns(run()).sum(axis=2) * SMALL
        scale = np.max(np.abs(expected))
        assert scale > 0.0
        np.testing.assert_allclose(shown[1] - shown[0], expected, atol=2e-3 * scale)


@pytest.mark.parametrize("joint", [0, 1])
def test_an_encoders_zero_is_that_of_the_springs_on_its_joint_too(joint):
    balancer = SpringBalancer("shoulder", d21=0.3, d22=0.8, phi=3.1)
    springs = {"Kr": 900.0, "K0": -40.0, "Ks2": 12.0, "Ts2": 1.5}
    model = nominal_model() + balancer + JointSpring(("elbow",))
    stated = {**model.stated, **{name: Prior(value, 1.0) for name, value in springs.items()}}
    model = replace(model, stated=stated)
    here = Driven.of(model, recording("identify", 0, length=6.0), "identify", Filtering())
    candidate = [*hypotheses("encoder_offset", model)][joint]
    values = model.nominal_values
    before = replace(evidence(), model=model, before=values, after=values)
    arms = as_nominal(before), as_found(before, [found(candidate)])
    shown = [arm.model.torque(here.motion, arm.values) for arm in arms]
    expected = candidate.columns(here).sum(axis=2) * SMALL
    np.testing.assert_allclose(shown[1] - shown[0], expected, atol=2e-3 * np.max(np.abs(expected)))


@pytest.mark.parametrize("effect", [*OF_MEASUREMENT, *BETWEEN])
def test_what_lies_between_arm_and_recordings_is_part_of_the_model(effect):
    candidates = BETWEEN[effect] if effect in BETWEEN else partial(hypotheses, effect)
    candidate = [*candidates(nominal_model())][-1]
    known = replace(evidence(), peak=np.array([60.0, 30.0]))
    arm = as_found(known, [found(candidate, 1.0)])
    assert arm.left_out == ()
    assert arm.model.measurements[0] in parse_model(model_text(arm.model)).measurements
    assert isinstance(arm.model.measurements[0], MEASUREMENTS[effect])


@pytest.mark.parametrize("effect", BETWEEN)
def test_a_gear_that_was_found_takes_the_torque_that_the_search_found(effect):
    candidate = [*BETWEEN[effect](nominal_model())][-1]
    one = found(candidate, 1.0)
    if effect == "backlash":
        one = replace(one, parameters={**one.parameters, "compliance": Quantity(0.0, np.nan, "rad/(N m)")})
    arm = as_found(evidence(), [one])
    expected = candidate.columns(run())[:, :, 0]
    assert np.max(np.abs(expected)) > 0.0
    torque, _ = arm.model.gear_torque(run().motion)
    np.testing.assert_allclose(torque, expected, atol=1e-6 * np.max(np.abs(expected)))


@pytest.mark.parametrize("effect", ["drive_gain_saturation", "current_clipping"])
def test_a_share_of_an_unknown_torque_is_no_part_of_the_model(effect):
    [candidate, *_] = hypotheses(effect, nominal_model())
    assert as_found(evidence(), [found(candidate)]).left_out == (0,)


def test_more_of_what_a_model_has_adds_to_it():
    candidate = [*hypotheses("coulomb_friction", nominal_model())][1]
    arm = as_found(evidence(), [found(candidate, 0.5), found(candidate, 0.25)])
    assert arm.model.names == nominal_model().names
    assert arm.by_name["Fc2"] == pytest.approx(as_nominal(evidence()).by_name["Fc2"] + 0.75)
    model = nominal_model() + Payload("L", (("M", 2.0),))
    known = replace(evidence(), model=model, before=model.nominal_values, after=model.nominal_values)
    [candidate] = hypotheses("payload", model)
    arm = as_found(known, [found(candidate)])
    assert arm.by_name["M2"] == pytest.approx(as_nominal(known).by_name["M2"] + SMALL)
    [candidate, *_] = hypotheses("drive_gain", nominal_model())
    one = replace(diagnosis(), findings=(found(candidate, 0.1),))
    np.testing.assert_allclose(
        model_to_fit(one).robot.drive_gain / nominal_model().robot.drive_gain, [1.1, 1.0]
    )


def test_refitting_finds_the_spring_and_explains_what_was_held_out():
    fit = refit(diagnosis(), [(one.settings["role"], one) for one in recordings()])
    assert fit.value("Ks2") == pytest.approx(STIFFNESS, rel=0.02)
    assert fit.runs == ("identify0", "identify1")
    assert fit.validation[0].run == "validate2"
    assert fit.validation[0].over_noise[1] < 2.0


def test_a_fit_takes_late_currents_back():
    [candidate, *_] = hypotheses("time_delay", nominal_model())
    both = replace(diagnosis(), findings=(*diagnosis().findings, found(candidate.reshaped({"delay": 0.004}))))
    late = [
        (
            one.settings["role"],
            replace(one, signals={**one.signals, "current": rolled(one.signals["current"])}),
        )
        for one in recordings()
    ]
    fit = refit(both, late)
    assert fit.model.measurements[0] == TimeDelay(0.004)
    assert fit.value("Ks2") == pytest.approx(STIFFNESS, rel=0.02)
    assert fit.validation[0].over_noise[1] < 2.0


def rolled(signal: Signal) -> Signal:
    """A sample, 4 ms, later."""
    return Signal(signal.time, np.roll(signal.values, 1, axis=0))


def test_models_of_what_was_found_and_of_what_it_might_be_are_files():
    model = found_model(diagnosis())
    again = parse_model(model_text(model))
    assert dict(zip(again.names, again.nominal_values, strict=True))["Ks2"] == pytest.approx(
        STIFFNESS, rel=0.1
    )
    others = rivals(diagnosis())
    assert len(others) == bool(diagnosis().findings[0].alternatives)
    assert all("Ks2" not in one.model.names for one in others)
    assert found_model(replace(diagnosis(), evidence=None)) is None


def test_bodies_that_a_diagnosis_holds_back_by_nothing_are_likely_in_a_fit():
    """Else what torque does not show of them is whatever the solver ends at, and differs from run to run."""
    one, stated = diagnosis(), nominal_model().robot.inertial_tolerance
    assert model_to_fit(one).robot.inertial_tolerance == stated
    open_ = replace(nominal_model().robot, inertial_tolerance=100.0, inertias_stated=False)
    evidence = replace(one.evidence, model=replace(one.evidence.model, robot=open_))
    assert model_to_fit(replace(one, evidence=evidence)).robot.inertial_tolerance == 0.1
