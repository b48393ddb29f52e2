"""Drive gains that are off within their tolerance: the intervals of diagnosed numbers contain the truth."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.results.evidence import deviations, places_of
from exidyn.identification.diagnosis.results.motor_torque import with_all_torque
from exidyn.identification.diagnosis.search.problem import Problem
from exidyn.identification.effects import JointSpring, StribeckFriction
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.identified import identified
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.text_table import NORMAL_95

from ...parts.small import two_joints
from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import problem, record, searched
from ...parts.small.two_joint_files import NOMINAL, WRONG, run

pytestmark = [pytest.mark.numerical, pytest.mark.slow]

STIFFNESS = 12.0
OFF, TOLERANCE = 1.08, 0.08
"""Nominal gain over the true one, and what the description says of it."""


def model(stated: bool = True) -> Model:
    """Nominal gains are too large, within their tolerance; inertias may be unstated."""
    known = nominal_model()
    gains = {"drive_gain": OFF * two_joints.GAIN, "drive_gain_tolerance": TOLERANCE}
    return replace(known, robot=replace(known.robot, **gains, inertias_stated=stated))


def stiffness(stated: bool) -> tuple[float, float]:
    """A spring's stiffness as it is found, with its standard deviation."""
    runs = record([JointSpring(("elbow",))], {"Ks2": STIFFNESS}, model=model(stated))
    found = with_all_torque(searched(runs, model(stated)))
    [place] = [k for k, one in enumerate(found.selected) if one.answer.candidate.effect == "joint_spring"]
    return float(found.prediction.values[places_of(found, place)][0]), float(deviations(found)[place][0][0])


@pytest.mark.long
def test_known_masses_correct_the_gain_and_with_it_the_finding():
    value, std = stiffness(stated=True)
    assert abs(value - STIFFNESS) <= NORMAL_95 * std
    assert std < 0.5 * TOLERANCE * STIFFNESS


def test_without_known_masses_the_tolerance_of_the_gain_is_in_the_interval():
    value, std = stiffness(stated=False)
    assert std > 0.5 * TOLERANCE * STIFFNESS  # the tolerances of friction tell something of the gain
    assert abs(value - STIFFNESS) <= NORMAL_95 * std


@pytest.mark.long
def test_inertias_that_were_identified_with_the_gains_move_with_them():
    """All gains together change nothing then but the torque that the model does not have: friction's here."""

    def usual(by_gain: bool) -> np.ndarray:
        known = model()
        known = replace(known, robot=replace(known.robot, inertias_by_gain=by_gain), stated={})
        made: Problem = problem(record(model=known), known)
        places = [made.rows.names.index(f"gain{joint}") for joint in (1, 2)]
        together = made.rows.columns[:, :, places].sum(axis=2)
        return np.sqrt(np.mean(together**2, axis=0))

    assert np.all(usual(True) < 0.4 * usual(False))


@pytest.mark.long
def test_the_mass_of_a_payload_is_as_uncertain_as_the_gains_that_the_model_was_identified_with():
    tolerance = replace(NOMINAL, robot=replace(NOMINAL.robot, drive_gain_tolerance=np.full(2, 0.1)))
    known = identified(identify([run("a"), run("b", 1, 2)], model=tolerance, as_recorded=True))
    known = replace(known, robot=replace(known.robot, inertias_stated=True, inertial_tolerance=0.02))
    # Runs with a body of which nobody says anything.
    carrying = [
        replace(run(f"with {seed}", seed, seed, KnownPayload("L")), payload=None) for seed in (3, 4, 5)
    ]
    runs = list(zip(("identify", "identify", "validate"), carrying, strict=True))
    found = diagnose(known, runs, as_recorded=True)
    [mass] = [one.parameters["M"] for one in found.findings if one.effect == "payload"]
    assert mass.value / 3.0 == pytest.approx(WRONG, abs=0.04)
    assert abs(mass.value - 3.0) <= NORMAL_95 * mass.std


def test_gains_that_nobody_states_are_those_of_the_described_masses_and_cause_no_finding():
    """In amperes, joints that share a body contradict each other, which looks like many effects."""
    stated = nominal_model()
    bare = replace(
        stated, stated={}, robot=replace(stated.robot, drive_gain=np.ones(2), inertias_stated=False)
    )
    diagnosis = diagnose(bare, [(role, replace(run, model=bare)) for role, run in record([], {})])
    assert not diagnosis.findings
    assert diagnosis.torque_units == ("N m", "N m")
    assert "as uncertain as the gains by the described masses" in diagnosis.warnings[0]


def test_where_no_gain_is_stated_friction_is_found_in_amperes():
    """No gain scales it: nothing determines one where masses are free."""
    stated = nominal_model()
    robot = replace(stated.robot, drive_gain=np.ones(2), inertias_stated=False, inertial_tolerance=1.0)
    bare = replace(stated, stated={}, robot=robot)
    rising = StribeckFriction(("elbow",), fade=0.1, exponent=1.5)
    runs = record(
        [rising], {"Fs2": 2.0}, change=lambda role, motion, current: np.sign(two_joints.GAIN) * current
    )
    found = diagnose(bare, [(role, replace(run, model=bare)) for role, run in runs], as_recorded=True)
    [one] = found.findings
    assert (one.effect, one.joints) == ("stribeck_friction", (1,))
    assert one["Fs2"].value == pytest.approx(2.0 / two_joints.GAIN[1], rel=0.05)
    assert found.torque_units == ("A", "A")
    assert found.warnings[0].startswith("no drive gain is known, so torques are in amperes")
