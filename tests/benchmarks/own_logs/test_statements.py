"""What the benchmark of logs counts as true, as named, and as said with which probability."""

import numpy as np
import pytest
from parts.own_logs.engine import claims_in
from parts.own_logs.known import Known
from parts.own_logs.mistakes import MISTAKES
from parts.own_logs.more_mistakes import MORE
from parts.own_logs.statements import Statement, altered, calibration, judged, of_init
from parts.own_logs.walk_mistake import names_cure

TIME = np.arange(0.0, 10.0, 0.01)
RIGHT = {
    "t": TIME,
    "q1": np.sin(TIME),
    "q2": np.cos(1.3 * TIME),
    "i1": np.sin(2.0 * TIME + 1),
    "i2": np.cos(3.1 * TIME),
}
KNOWN = Known(
    "s",
    "rad",
    "",
    "current",
    np.array([10.0, 5.0]),
    {"time": ["t"], "position": ["q1", "q2"], "current": ["i1", "i2"]},
)


def guess(what, value, probability=0.999):
    return {"what": what, "value": value, "probability": probability, "decided": probability >= 0.95}


def proposal(*gains, position="rad"):
    guesses = [guess(f"gain of joint{place + 1}", "") for place in range(len(gains))]
    known = [{"value": value, "known": True} for value in gains]
    return {"guesses": guesses, "gains": known, "columns": KNOWN.columns, "units": {"position": position}}


def test_truth_follows_from_what_was_changed():
    wrong = RIGHT | {"t": 1e3 * TIME, "q1": np.degrees(RIGHT["q2"]), "q2": np.degrees(RIGHT["q1"])}
    known = altered(KNOWN, RIGHT, wrong | {"i1": -2.0 * RIGHT["i1"]})
    assert (known.time, known.position) == ("ms", "deg")
    assert known.columns["position"] == ["q2", "q1"]
    np.testing.assert_allclose(known.gain, [-5.0, 5.0])


def test_no_unit_is_right_for_columns_in_two():
    assert altered(KNOWN, RIGHT, RIGHT | {"q1": 0.25 * RIGHT["q1"]}).position == "?"
    assert altered(KNOWN, RIGHT, RIGHT | {"q1": 100 + RIGHT["q1"], "q2": 100 + RIGHT["q2"]}).position == "?"


def test_gains_of_a_column_without_its_numbers_are_not_judged():
    known = altered(KNOWN, RIGHT, RIGHT | {"i1": np.abs(RIGHT["i1"])})
    assert [one.true for one in of_init("log", proposal(10.0, 20.0), known)] == [None, False]


@pytest.mark.parametrize(
    ("what", "value", "true"),
    [
        ("unit of position", "rad", True),
        ("unit of position", "deg", False),
        ("unit of i{number}", "not N m: needs gain", True),
        ("unit of i{number}", "N m of the joint", False),
        ("direction of gravity", "0.02, 0.00, -1.00 of the base", True),
        ("direction of gravity", "0.94, 0.00, -0.34 of the base", False),
        ("order of joints", "as numbered", True),
        ("current", "i{number}", True),
        ("torque", "torque_on", False),
    ],
)
def test_guesses_of_init(what, value, true):
    units = {"position": value} if what == "unit of position" else {}
    assert judged(guess(what, value), proposal(**units), KNOWN) is true


def test_a_gain_is_true_within_a_factor_of_two_and_of_its_sign():
    assert [one.true for one in of_init("log", proposal(6.0, 9.0), KNOWN)] == [True, True]
    assert [one.true for one in of_init("log", proposal(-10.0, 11.0), KNOWN)] == [False, False]


def test_calibration_leaves_out_what_nobody_knows():
    said = [(0.96, True), (0.98, False), (0.999, True), (0.995, None), (0.5, False)]
    rows = calibration([Statement("log", "", probability, true) for probability, true in said])
    assert rows == [["95 to 99 %", 2, 1, 50.0], ["> 99 %", 1, 1, 100.0]]


def test_printed_statements():
    text = "warning: run: x is in mA (probability > 99.9 %): state it\n"
    text += "exidyn: run: x (probability 99 %): y, --as-recorded\n"
    first, second = claims_in(text)
    assert (first.probability, first.refuses) == (pytest.approx(0.999), False)
    assert (second.probability, second.refuses) == (pytest.approx(0.99), True)
    assert first.text.endswith("state it")


def test_words_of_a_cure_stand_close_together():
    assert names_cure("the position of joint5 looks as if it were 0.25 of the angle", ("joint5", r"0\.25"))
    assert not names_cure(f"joint5 is fine. {'x' * 400} 0.25", ("joint5", r"0\.25"))


NAMED = {
    "torques without gravity": "the efforts lack the weight of the arm: gravity is compensated",
    "torques of joints 4 to 6 times 10": "the efforts of joint4, joint5 and joint6 are 10 times those stated",
    "positions times 1/4": "positions look as if they were 0.25 of the angle",
    "position of joint 5 times 1/4": "the position of joint5 looks as if it were 0.25 of the angle",
    "positions in per cent of travel": "positions are in per cent of the joints' range",
    "legs in another order": "the columns of FL_hip to FL_calf and of FR_hip to FR_calf are exchanged",
    "gear ratio of joint 4 is half": "the gear ratio of joint4 looks like 50, stated is 100: 0.5 times",
    "a sign lost before scaling": "i1 lost its sign: values lie in two bands 65536 steps apart",
    "position register of joint 2 that saturates": "the position of joint2 is clipped at 1.2 rad",
    "commands that are the next state": "commands are the positions of the next sample",
    "commands that are steps": "commands do not follow the positions: they look like steps",
    "no effort measured": "no effort was measured: all efforts are 0 throughout",
    "a body on the flange that nobody states": "a body on the flange: 2.00 ± 0.06 kg",
    "a payload stated with a wrong mass": "the runs say a mass of 2.00 ± 0.06 kg, stated are 1.6",
    "torques that are multiplied by the drive gain again": "the efforts are joint torques already",
    "stamps of arrival in bursts": "stamps come in bursts: they are times of arrival",
    "two runs in one file": "time begins anew at line 702: two runs",
    "servo gain of an MJCF is 998, not 18": "kp of the file is 998, the bodies say 18",
}
"""Cures as an engineer words them."""


@pytest.mark.parametrize("mistake", MORE, ids=lambda mistake: mistake.name)
def test_patterns_take_a_plain_sentence_and_no_general_one(mistake):
    assert names_cure(NAMED[mistake.name], mistake.says)
    assert not names_cure("More than noise is left on joint4 (6.6 x noise): state drive gains", mistake.says)


def test_names_of_mistakes_differ():
    names = [mistake.name for mistake in (*MISTAKES, *MORE)]
    assert len(set(names)) == len(names) >= 45
