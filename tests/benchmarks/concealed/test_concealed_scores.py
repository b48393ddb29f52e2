"""Scores of answers to concealed cases."""

from dataclasses import replace

import numpy as np
import pytest
from parts.concealed.effects.outside import OUTSIDE
from parts.concealed.effects.vocabulary import VOCABULARY
from parts.concealed.scoring.answers import Guess, Truth, read_answer
from parts.concealed.scoring.coverage import numbers
from parts.concealed.scoring.half_way import half_way
from parts.concealed.scoring.score import Pair, figures, simulated_share
from parts.concealed.scoring.tables import outside, print_scores, sensitivity

from exidyn.identification.diagnosis.candidates import kinds
from exidyn.identification.diagnosis.candidates.curves import NAMES

pytestmark = pytest.mark.slow


def truth_of(kind: str, *effects: tuple[str, set[int]], evidence: float = 1000.0) -> Truth:
    """A truth of two joints."""
    guesses = tuple(Guess(effect, frozenset(joints)) for effect, joints in effects)
    count = len(guesses)
    noise = np.array([1.0, 2.0])
    return Truth(
        "c", kind, "small", guesses, (3.0,) * count, (evidence,) * count, (), noise, 0.5 * noise, 25.0
    )


def answer_of(*findings: tuple[str, list[int]], unexplained: bool = False, others: list | None = None):
    """An answer of two joints, a tenth above the noise floor behind 25 Hz."""
    found = [
        {"effect": effect, "joints": joints, "confidence": 0.9, "alternatives": others or []}
        for effect, joints in findings
    ]
    return read_answer({
        "findings": found, "unexplained": unexplained, "torque_rms_after": [0.55, 1.1],
        "torque_rms_filter_hz": 25.0, "seconds": 2.0,
    })  # fmt: skip


def test_right_answers_have_full_marks():
    cases = [
        Pair(truth_of("single", ("stribeck_friction", {2})), answer_of(("stribeck_friction", [2]))),
        Pair(truth_of("single", ("time_delay", set())), answer_of(("time_delay", [1, 2]))),
        Pair(
            truth_of("double", ("payload", set()), ("backlash", {1})),
            answer_of(("backlash", [1]), ("payload", [])),
        ),
        Pair(truth_of("none"), answer_of()),
        Pair(truth_of("outside", ("hose_spring", set())), answer_of(unexplained=True)),
    ]
    found = figures(cases)
    ones = ("top1", "joint", "with_alternatives", "double_recall", "double_precision", "outside_unexplained")
    assert [found[name] for name in ones] == [1.0] * 6
    assert [found[name] for name in ("false_alarms", "outside_misnamed", "wrong_name")] == [0, 0, 0]
    assert found["residual_over_noise"] == pytest.approx(1.1)


def test_wrong_answers_have_none():
    truth = truth_of("single", ("stribeck_friction", {2}))
    wrong = figures([Pair(truth, answer_of(("stribeck_friction", [1])))])
    assert (wrong["top1"], wrong["joint"], wrong["wrong_name"]) == (0.0, 0.0, 1.0)
    other = answer_of(("hysteresis", [2]), others=["stribeck_friction"])
    near = figures([Pair(truth, other)])
    assert (near["top1"], near["joint"], near["with_alternatives"]) == (0.0, 1.0, 1.0)
    elsewhere = answer_of(("hysteresis", [1]), others=[{"effect": "stribeck_friction", "joints": [2]}])
    assert figures([Pair(truth, elsewhere)])["with_alternatives"] == 1.0
    three = answer_of(("backlash", [1]), ("payload", []), ("hysteresis", [1]))
    half = figures([Pair(truth_of("double", ("payload", set()), ("backlash", {1})), three)])
    assert (half["double_recall"], half["double_precision"]) == (1.0, pytest.approx(2 / 3))
    assert figures([Pair(truth_of("none"), answer_of(unexplained=True))])["false_alarms"] == 1
    assert (
        figures([Pair(truth_of("outside", ("hose_spring", set())), answer_of(("payload", [])))])[
            "outside_misnamed"
        ]
        == 1.0
    )


def test_what_no_oracle_sees_is_not_asked():
    hidden = Pair(truth_of("single", ("payload", set()), evidence=10.0), answer_of())
    seen = Pair(truth_of("single", ("payload", set())), answer_of(("payload", [])))
    found = figures([hidden, seen])
    assert (found["top1"], found["top1_all_strengths"]) == (1.0, 0.5)


def test_the_strength_found_half_of_the_time():
    strengths = np.geomspace(0.1, 10.0, 41)
    middle, low, high = half_way([(value, value > 0.8) for value in strengths])
    assert middle == pytest.approx(0.8, rel=0.1)
    assert low < 0.8 < high


def test_simulation_counts_on_the_joints_concerned():
    truth = truth_of("single", ("viscous_friction", {2}))
    count = len(truth.noise)
    answer = replace(
        answer_of(("viscous_friction", [2])),
        simulated_before=np.full(count, 4.0),
        simulated_after=np.where(np.arange(count) == 1, 1.0, 9.0),
    )
    assert simulated_share(Pair(truth, answer)) == pytest.approx(0.25)
    found = figures([Pair(truth, answer)])
    assert (found["simulated"], found["simulated_better"]) == (1, 1.0)
    [[effect, half, low, high, count]] = sensitivity([Pair(truth, answer)])
    assert (effect, count) == ("viscous_friction", 1)
    assert low < half < 3.0 < high  # it was found at three times the noise


def test_candidates_have_the_names_of_what_is_concealed():
    assert set(VOCABULARY) <= set(kinds())
    curves = {*NAMES.values(), "torque_curve", "periodic_disturbance"}
    # What warms has its temperature recorded there, and the arms' controllers compensate nothing themselves.
    unconcealed = curves | {"warming_friction", "gravity_compensation"}
    assert set(kinds()) - set(VOCABULARY) - unconcealed < set(OUTSIDE)


def test_what_is_outside_and_asked_for_is_apart_from_what_nobody_asks_for():
    asked, never = "hose_spring", "floor_vibration"
    cases = [
        Pair(truth_of("outside", (asked, set())), answer_of(unexplained=True)),
        Pair(truth_of("outside", (asked, set())), answer_of(("payload", []))),
        Pair(truth_of("outside", (never, set())), answer_of(("payload", []), unexplained=True)),
        Pair(truth_of("single", ("payload", set())), answer_of(("payload", []))),
    ]
    assert outside(cases) == [["has a candidate", 2, 0.5, 0.5], ["has none", 1, 1.0, 1.0]]
    assert print_scores({"product": cases})["outside"] == outside(cases)
    assert not outside(cases[3:])


def test_answers_without_values_stand_beside_the_others(capsys):
    truth = truth_of("single", ("payload", set()))
    right, wrong = [Pair(truth, answer_of(("payload", [])))], [Pair(truth, answer_of(("backlash", [1])))]
    found = print_scores({"product": right, "bare": wrong})
    alone = print_scores({"bare": wrong})
    assert (found["top1"], found["bare"]["top1"]) == (1.0, 0.0)
    assert found["bare"]["confusion"] == [["payload", "backlash", 1]]
    assert found["bare"].keys() == alone.keys() == found.keys() - {"bare"}
    both, single = capsys.readouterr().out.split("\nconcealed cases")[1:]
    assert both.split()[:3] == ["figure", "product", "bare"]
    assert ["top1", "1", "0"] in [line.split() for line in both.splitlines()]
    assert ["top1", "0"] in [line.split() for line in single.splitlines()]


def sized(true: float, value: float | None, std: float | None) -> Pair:
    """A joint's friction by load, concealed and diagnosed."""
    truth = replace(truth_of("single", ("load_dependent_friction", {2})), parameters=({"mu": true},))
    found = {"effect": "load_dependent_friction", "joints": [2], "confidence": 1.0}
    return Pair(truth, read_answer({"findings": [found | {"parameters": {"mu2": [value, std]}}]}))


def test_intervals_of_diagnosed_numbers_are_held_against_the_truth():
    cases = [sized(0.10, 0.11, 0.01), sized(0.10, 0.13, 0.01), sized(0.10, 0.13, None)]
    found = figures(cases)
    assert (found["intervals"], found["interval_coverage"]) == (2, 50.0)
    [row] = print_scores({"product": cases})["coverage"]
    assert row[:4] == ["load_dependent_friction", "mu", 2, 50.0]
    assert row[4:] == pytest.approx([20.0, 19.6, np.sqrt(5.0)])


def test_numbers_of_a_wrong_name_do_not_count():
    truth = replace(truth_of("single", ("payload", set())), parameters=({"mass": 3.0},))
    found = figures([Pair(truth, sized(0.10, 0.11, 0.01).answer)])
    assert found["intervals"] == 0
    assert np.isnan(found["interval_coverage"])


def test_the_truth_is_in_the_names_of_the_diagnosis():
    lean = {"degrees": 2.0, "heading": np.pi / 2}
    stated = {"tilt_x": [0.0, 0.001], "tilt_y": [0.035, 0.001]}
    found = numbers(Guess("base_tilt", frozenset()), lean, stated)
    assert [(one.name, one.held) for one in found] == [("tilt_x", True), ("tilt_y", True)]
    assert not numbers(Guess("rotor_inertia", frozenset({1})), {"missing": False}, {"Ia1": [1.0, 0.1]})
    assert not numbers(Guess("hysteresis", frozenset({1})), {"torque": 1.0}, {"Fh1": [1.0, 0.1]})
