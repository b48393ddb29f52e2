"""Diagnosis of real recordings with plain priors, and the scores of that benchmark."""

import json
from dataclasses import replace

import numpy as np
import pytest
from diagnose_real import score
from parts.diagnose_real.answer import alike, named
from parts.diagnose_real.known import COGGING, KNOWN, ripple
from parts.diagnose_real.sets import CASES, FOLDER
from parts.proof.page import named_words
from parts.proof.simulated import simulated_section

from exidyn.identify.diagnosis.diagnose import diagnose
from exidyn.identify.diagnosis.findings.finding import Finding, Quantity
from exidyn.identify.diagnosis.questions.candidate import Candidate

needs_recordings = pytest.mark.skipif(
    not (FOLDER / "emps").is_dir(), reason=f"no real recordings in {FOLDER}; set EXIDYN_DATA"
)


def wave(harmonic, amplitude, joint=0, effect="torque_ripple"):
    numbers = {
        f"R{wave}{harmonic:g}_1": Quantity(share * amplitude, 0.01, "N m")
        for wave, share in (("cos", 0.6), ("sin", 0.8))
    }
    numbers["harmonic"] = Quantity(harmonic, 0.001, "1")
    asked = Candidate(effect, (joint,), lambda run: np.zeros((1, 1, 1)), (), (), ())
    return Finding(effect, (joint,), numbers, 0.99, (), np.zeros(1), 1.0, asked)


def test_a_known_ripple_is_one_of_that_harmonic():
    known = ripple(0, 7, 0.862, "map", "A")
    assert known.is_in([wave(28.0, 0.5), wave(7.2, 0.862)]) is not None
    assert known.is_in([wave(28.0, 0.5), wave(7.0, 0.862, joint=1)]) is None
    assert known.right(wave(7.0, 0.862)) is True
    assert known.right(wave(7.0, 0.5)) is False
    assert COGGING.is_in([wave(28.0, 0.5), wave(7.0, 0.862)]) is None  # it has to be the first


@pytest.mark.parametrize("pair", ["5_6", "6_5"])
def test_a_coupling_is_right_by_either_joint(pair):
    coupling = next(known for known in KNOWN["tx40"] if known.effect == "kinematic_coupling")
    sizes = {"Ia": 0.0096, "Fv": 0.6, "Fc": 1.9}
    numbers = {f"{name}{pair}": Quantity(value, 0.05, "1") for name, value in sizes.items()}
    finding = replace(wave(1.0, 1.0), effect="kinematic_coupling", joints=(4, 5), parameters=numbers)
    assert coupling.right(finding) is True
    wrong = numbers | {f"Fc{pair}": Quantity(1.0, 0.05, "1")}
    assert coupling.right(replace(finding, parameters=wrong)) is False


def test_a_name_that_the_source_excludes_is_false_and_all_are_on_a_control():
    motor, control = CASES["odrive_off"], CASES["odrive_on"]
    assert named(motor, wave(7.0, 0.8)).verdict == "known"
    assert named(motor, wave(9.0, 0.8)).verdict == "unverified"
    assert named(motor, wave(1.0, 0.8, effect="joint_elasticity")).verdict == "false"
    assert named(control, wave(7.0, 0.8)).verdict == "false"


def test_the_score_counts_names_misses_and_joints_that_are_predicted_worse():
    unsure = [{"instead": 0.9}, {"instead": 0.3}]
    row = {"counted": True, "named": True, "right": False}
    one = {
        "case": "emps",
        "known": [row, row | {"named": False}, row | {"counted": False}],
        "named": [{"verdict": "false"}, {"verdict": "unverified"}, {"verdict": "known"}],
        "undecided": unsure,
        "again": {"same": ["once more"]},
        "improvement": {"before": [1.0, 1.0], "after": [1.03, 1.01]},
        "seconds": 3.0,
        "process_seconds": 2.0,
    }
    aside = one | {"case": "odrive_off_set"}  # a row that does not count
    figures = score([one, aside])
    assert (figures["known"], figures["known_named"], figures["known_named_percent"]) == (2, 1, 50.0)
    assert (figures["false_names"], figures["unverified"], figures["worse_held_out"]) == (2, 1, 1)
    assert figures["false_names_not_counted"] == 1
    assert figures["named_otherwise"] == 1
    assert figures["seconds"] == 3.0


def test_a_ripple_is_its_strongest_harmonic():
    seventh, other = wave(7.0, 0.862), wave(28.0, 0.5)
    comb = replace(other, parameters={**wave(7.0, 0.01).parameters, **other.parameters})
    comb.parameters.pop("harmonic")
    assert alike(comb, other)
    assert not alike(comb, seventh)


def test_the_page_reports_it_where_another_name_is_likely():
    sure = {
        "effect": "joint_spring",
        "joints": "J6",
        "probability": 0.001,
        "size": "",
        "verdict": "undecided",
    }
    sure |= {"why": "torque_ripple J6 1.00", "instead": 1.0}
    text = named_words({"named": [], "undecided": [sure]})
    assert text.startswith("Nothing is named. joint spring J6 is in the fit without a name")
    assert "torque ripple J6 1.00" in text
    assert named_words({"named": [], "undecided": []}) == "Nothing is named.\n"


def test_sixteen_effects_are_counted():
    assert sum(known.counted for case in CASES.values() if case.counted for known in case.known) == 16
    assert not CASES["panda"].known
    assert set(KNOWN) == {"odrive", *(key for key in CASES if not key.startswith("odrive"))}


def diagnosed(key):
    case = CASES[key]
    model, runs = case.ask()
    assert not model.robot.inertias_stated
    assert not any(name.startswith(("Fc", "Fv")) for name in model.stated)
    return case, diagnose(model, runs, key, case.filtering)


@needs_recordings
def test_asymmetric_drag_of_the_emps():
    case, found = diagnosed("emps")
    [known] = case.known
    finding = known.is_in(found.findings)
    assert finding is not None
    assert known.right(finding)


@needs_recordings
def test_coupled_wrist_of_the_tx40(monkeypatch):
    monkeypatch.setattr("exidyn.identify.diagnosis.search.search.TURNS", 3)  # its other three take longer
    case, found = diagnosed("tx40")
    coupling = next(known for known in case.known if known.effect == "kinematic_coupling")
    assert coupling.is_in(found.findings) is not None


@needs_recordings
def test_cogging_of_a_motor_is_named_with_compensation_off():
    case, found = diagnosed("odrive_off")
    cogging = next(known for known in case.known if known.counted)
    assert cogging.is_in(found.findings) is not None


@needs_recordings
@pytest.mark.parametrize("key", ["panda", "odrive_on"])
def test_nothing_is_named_on_a_control(key):
    assert diagnosed(key)[1].findings == ()


@needs_recordings
def test_compensation_takes_away_most_of_the_ripple_in_one_signal_and_one_band():
    """By default filters the control is compared below the ripple's frequency; here both states show it."""
    off, on = (diagnosed(f"odrive_{state}_setpoint_given")[1] for state in ("nocomp", "comp"))
    assert off.improvement.band == on.improvement.band
    assert replace(COGGING, first=False).is_in(off.findings) is not None
    assert seventh(on) < 0.5 * seventh(off)


def seventh(found):
    """Amplitude of the seventh harmonic of what was named [A]; zero if it was not."""
    amplitudes = [
        np.hypot(*(one.parameters[name].value for name in one.parameters if name.startswith("R")))
        for one in found.findings
        if one.effect == "torque_ripple" and abs(one.parameters["harmonic"].value - 7.0) < 0.1
    ]
    return max(amplitudes, default=0.0)


def test_page_has_the_scores_of_simulated_arms_beside_each_other(tmp_path):
    score = {
        "cases": 98, "detectable": 37, "top1": 0.95, "with_alternatives": 0.973, "false_alarms": 1,
        "nothing_cases": 7, "double_recall": 0.91, "double_precision": 1.0, "outside_misnamed": 0.25,
        "confusion": [["time_delay", "coulomb_friction", 2]],
    }  # fmt: skip
    file = tmp_path / "concealed.json"
    file.write_text(json.dumps(score | {"bare": score | {"top1": 0.81}}))
    page = simulated_section(file)
    assert "| of these, named, on the right joint, first | 95 % | 81 % |" in page
    assert "| nothing missing, and something named | 1 of 7 cases | 1 of 7 cases |" in page
    assert "called otherwise: time delay as coulomb friction (2)." in page
