"""Diagnosis of real recordings with plain priors, and the scores of that benchmark."""

import json
from dataclasses import replace

import numpy as np
import pytest
from parts.diagnose_real import answer as answering
from parts.diagnose_real.answer import kept, named
from parts.diagnose_real.known import COGGING, KNOWN, ripple
from parts.diagnose_real.score import score
from parts.diagnose_real.sets import CASES, FOLDER
from parts.diagnose_real.sizes import number
from parts.proof.page import named_words
from parts.proof.simulated import simulated_section

from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.findings.finding import Finding
from exidyn.identification.quantity import Quantity

pytestmark = pytest.mark.slow

needs_recordings = pytest.mark.skipif(
    not (FOLDER / "emps").is_dir(), reason=f"no real recordings in {FOLDER}; set EXIDYN_DATA"
)


def wave(harmonic, amplitude, joint=0, effect="torque_ripple"):
    numbers = {
        f"R{wave}{harmonic:g}_1": Quantity(share * amplitude, 0.01, "N m")
        for wave, share in (("cos", 0.6), ("sin", 0.8))
    }
    numbers["harmonic"] = Quantity(harmonic, 0.001, "1")
    return Finding(
        effect=effect,
        joints=(joint,),
        parameters=numbers,
        probability=0.99,
        torque_rms=np.zeros(1),
        held_out=1.0,
    )


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
    ripple_7, again = wave(7.0, 0.8), wave(7.0, 0.1)
    assert named(motor, ripple_7, [ripple_7, again]).verdict == "known"
    assert named(motor, again, [ripple_7, again]).verdict == "unverified"
    assert alone(motor, wave(9.0, 0.8)) == "unverified"
    assert alone(motor, wave(1.0, 0.8, effect="joint_elasticity")) == "false"
    assert alone(control, ripple_7) == "false"


def alone(case, finding):
    return named(case, finding, [finding]).verdict


def row_of(case, joints=1, named_again=()):
    row = {"expected": True, "named": True, "by_family": True, "right": False}
    return {
        "case": case,
        "known": [row, row | {"named": False}, row | {"expected": False}],
        "named": [{"verdict": "false"}, {"verdict": "unverified"}, {"verdict": "known"}],
        "undecided": [{"instead": 0.9}, {"instead": 0.3}],
        "again": {"named": list(named_again), "repeated": list(named_again)[:1]},
        "improvement": {"before": [1.0, 1.0], "after": [1.03, 1.01]},
        "seconds": 3.0,
        "process_seconds": 2.0,
        "data_seconds": 60.0,
        "joints": joints,
    }


def test_the_score_counts_names_misses_and_joints_of_every_row():
    figures = score([row_of("emps"), row_of("odrive_comp_setpoint_given"), row_of("tx40", joints=6)])
    assert (figures["known"], figures["known_named"], figures["known_named_percent"]) == (6, 3, 50.0)
    assert (figures["false_names"], figures["unverified"], figures["names"]) == (3, 3, 9)
    assert (figures["worse_held_out"], figures["named_otherwise"]) == (3, 3)
    assert (figures["cpu_seconds_per_minute"], figures["cpu_seconds_per_minute_set"]) == (2.0, "tx40")
    assert score([row_of("emps")])["cpu_seconds_per_minute"] is None


def test_a_fixed_point_is_a_second_diagnosis_that_names_nothing_on_any_set():
    figures = score([row_of("emps"), row_of("kr300", named_again=["joint_elasticity J1"])])
    assert (figures["fixed_point"], figures["at_fixed_point"]) == (False, 1)
    assert figures["at_fixed_point_but_for_what_no_model_holds"] == 2
    assert score([row_of("emps")])["fixed_point"] is True
    assert score([row_of("emps", named_again=["backlash J1", "hysteresis J1"])])["fixed_point"] is False
    assert score([row_of("emps") | {"again": None}])["fixed_point"] is False


def test_an_answer_that_is_kept_is_not_asked_again(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(answering, "answer", lambda key, twice: asked.append(key) or {"again": twice or None})
    for twice in (False, False, True, True):
        kept("emps", tmp_path, twice)
    assert asked == ["emps", "emps"]  # of the first, nothing was diagnosed twice


def test_a_number_at_its_limit_has_no_deviation():
    assert number("Kr", 0.0, 1e-12, "N/m") == "Kr 0 N/m (at its limit, not measured)"
    assert number("mu", 0.2, 0.04, "1") == "mu 0.2 ± 0.04"


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


def test_every_set_has_what_is_known_of_it():
    assert set(KNOWN) == {"odrive", *(key for key in CASES if not key.startswith("odrive"))}
    assert {key for key, case in CASES.items() if case.control} == {
        "panda", "dvrk_psm", "odrive_on", "odrive_comp_setpoint_given",
    }  # fmt: skip
    assert not any(case.known for case in CASES.values() if case.control)


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


@pytest.mark.long
@needs_recordings
def test_coupled_wrist_of_the_tx40():
    case, found = diagnosed("tx40")
    coupling = next(known for known in case.known if known.effect == "kinematic_coupling")
    assert coupling.is_in(found.findings) is not None


@needs_recordings
def test_cogging_of_a_motor_is_named_with_compensation_off():
    case, found = diagnosed("odrive_off")
    cogging = next(known for known in case.known if known.expected)
    assert cogging.is_in(found.findings) is not None


@needs_recordings
@pytest.mark.parametrize("key", ["panda", "odrive_on"])
def test_nothing_is_named_on_a_control(key):
    assert diagnosed(key)[1].findings == ()


@needs_recordings
def test_compensation_takes_away_most_of_the_ripple_in_one_signal_and_one_band():
    """By default filters the control is compared below the ripple's frequency; here both states show it."""
    off, on = (diagnosed(f"odrive_{state}_setpoint_given")[1] for state in ("nocomp", "comp"))
    assert off.torque_rms_filter_hz == on.torque_rms_filter_hz
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
