"""The arithmetic of benchmarks, which could give wrong figures without anybody noticing."""

from types import SimpleNamespace

import numpy as np
import pytest
import size
from common import Kept
from injected import score as injected_score
from parts.concealed.scoring import Guess, Number, Pair, Truth, figures, interval_coverage, read_answer
from parts.diagnose_real.known import COGGING, ripple
from parts.diagnose_real.score import score as real_score
from parts.own_logs.tables import Known, Statement, altered, calibration, judged

from exidyn.identification.diagnosis.findings.finding import Finding
from exidyn.identification.quantity import Quantity


def test_results_that_are_kept_are_not_made_again(tmp_path):
    file = tmp_path / "results"
    Kept(file).of("first", lambda: {"history": [(0.5, np.float64(3.0))]})
    with file.open("a") as cut:
        cut.write('["second", {"histo')  # killed as it wrote
    again = Kept(file)
    assert again.of("first", lambda: pytest.fail("made twice")) == {"history": [[0.5, 3.0]]}
    again.put("second", 2)
    assert Kept(file).found == {"first": {"history": [[0.5, 3.0]]}, "second": 2}


def test_a_limit_that_is_exceeded_is_one_sentence(tmp_path, capsys):
    for folder in ("identify/arm", "tests", "benchmarks"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "x.py").write_text("a = 1\nb = 2\n")
    (tmp_path / "identify" / "link.py").symlink_to(tmp_path / "tests" / "x.py")
    for tests, code in ((2, 0), (1, 1)):
        limits = f"[tool.exidyn.size]\nproduct = 2\ntests = {tests}\nbenchmarks = 9\n"
        (tmp_path / "pyproject.toml").write_text(limits)
        assert size.main(["--check"], tmp_path) == code
        out, errors = capsys.readouterr()
        assert out == ""
        assert errors.count("\n") == code
    assert "tests has 2 lines of Python, 1 more than the limit of 1" in errors
    assert size.line_counts(tmp_path) == {"product": 2, "tests": 2, "benchmarks": 2}


def case(kind, concealed, named=(), unexplained=False, evidence=1000.0, others=()):
    """A truth of two joints and an answer to it; effects are pairs of a name and joints from 1."""
    guesses = tuple(Guess(effect, frozenset(joints)) for effect, joints in concealed)
    count, noise = len(guesses), np.array([1.0, 2.0])
    truth = Truth(
        "c", kind, "small", guesses, (3.0,) * count, (evidence,) * count, (), noise, 0.5 * noise, 25.0
    )
    found = [
        {"effect": effect, "joints": joints, "confidence": 0.9, "alternatives": others}
        for effect, joints in named
    ]
    answer = {"findings": found, "unexplained": unexplained, "torque_rms_after": [0.55, 1.1]}
    return Pair(truth, read_answer(answer | {"torque_rms_filter_hz": 25.0, "seconds": 2.0}))


STRIBECK, BACKLASH, PAYLOAD = ("stribeck_friction", [2]), ("backlash", [1]), ("payload", [])


def test_right_answers_to_concealed_cases_have_full_marks_and_wrong_ones_none():
    right = figures([
        case("single", [STRIBECK], [STRIBECK]),
        case("single", [("time_delay", [])], [("time_delay", [1, 2])]),
        case("double", [PAYLOAD, BACKLASH], [BACKLASH, PAYLOAD]),
        case("none", []),
        case("outside", [("hose_spring", [])], unexplained=True),
    ])  # fmt: skip
    ones = ("top1", "joint", "with_alternatives", "double_recall", "double_precision", "outside_unexplained")
    assert [right[name] for name in ones] == [1.0] * 6
    assert [right[name] for name in ("false_alarms", "outside_misnamed", "wrong_name")] == [0, 0, 0]
    assert right["residual_over_noise"] == pytest.approx(1.1)
    elsewhere = figures([case("single", [STRIBECK], [("stribeck_friction", [1])])])
    assert (elsewhere["top1"], elsewhere["joint"], elsewhere["wrong_name"]) == (0.0, 0.0, 1.0)
    near = figures([case("single", [STRIBECK], [("hysteresis", [2])], others=["stribeck_friction"])])
    assert (near["top1"], near["joint"], near["with_alternatives"]) == (0.0, 1.0, 1.0)
    three = figures([case("double", [PAYLOAD, BACKLASH], [BACKLASH, PAYLOAD, ("hysteresis", [1])])])
    assert (three["double_recall"], three["double_precision"]) == (1.0, pytest.approx(2 / 3))
    assert figures([case("none", [], unexplained=True)])["false_alarms"] == 1
    assert figures([case("outside", [("hose_spring", [])], [PAYLOAD])])["outside_misnamed"] == 1.0
    hidden = figures([case("single", [PAYLOAD], evidence=10.0), case("single", [PAYLOAD], [PAYLOAD])])
    assert (hidden["top1"], hidden["top1_all_strengths"]) == (1.0, 0.5)


def test_intervals_that_contain_the_truth_are_counted():
    numbers = [Number("payload", "M", 2.0, value, 0.1) for value in (2.0, 2.19, 2.2, 1.7)]
    assert interval_coverage(numbers) == 50.0
    assert np.isnan(interval_coverage([]))


def test_names_on_real_recordings_are_counted():
    row = {"expected": True, "named": True, "by_family": True, "right": False}
    answer = {
        "case": "emps",
        "known": [row, row | {"named": False}, row | {"expected": False}],
        "named": [{"verdict": "false"}, {"verdict": "unverified"}, {"verdict": "known"}],
        "undecided": [{"instead": 0.9}, {"instead": 0.3}],
        "again": {"named": [], "repeated": []},
        "improvement": {"before": [1.0, 1.0], "after": [1.03, 1.01]},
        "seconds": 3.0, "process_seconds": 2.0, "data_seconds": 60.0, "joints": 6,
    }  # fmt: skip
    once_more = answer | {"case": "tx40", "again": {"named": ["backlash J1"], "repeated": []}}
    found = real_score([answer, once_more])
    assert (found["known"], found["known_named"], found["known_named_percent"]) == (4, 2, 50.0)
    assert (found["false_names"], found["unverified"], found["names"]) == (2, 2, 6)
    assert (found["worse_held_out"], found["named_otherwise"], found["cpu_seconds_per_minute"]) == (2, 2, 2.0)
    assert (found["fixed_point"], found["at_fixed_point"], real_score([answer])["fixed_point"]) == (
        False,
        1,
        True,
    )


def test_a_known_ripple_is_one_of_that_harmonic():
    def wave(harmonic, amplitude, joint=0):
        shares = {f"Rcos{harmonic:g}_1": 0.6, f"Rsin{harmonic:g}_1": 0.8}
        numbers = {name: Quantity(share * amplitude, 0.01, "N m") for name, share in shares.items()}
        numbers["harmonic"] = Quantity(harmonic, 0.001, "1")
        fields = {"probability": 0.99, "torque_rms": np.zeros(1), "held_out": 1.0}
        return Finding(effect="torque_ripple", joints=(joint,), parameters=numbers, **fields)

    known = ripple(0, 7, 0.862, "map", "A")
    assert known.is_in([wave(28.0, 0.5), wave(7.2, 0.862)]) is not None
    assert known.is_in([wave(28.0, 0.5), wave(7.0, 0.862, joint=1)]) is None
    assert (known.right(wave(7.0, 0.862)), known.right(wave(7.0, 0.5))) == (True, False)
    assert COGGING.is_in([wave(28.0, 0.5), wave(7.0, 0.862)]) is None  # it has to be the first


def test_names_of_injected_effects_are_counted():
    spring = {"effect": "joint_spring", "joints": (0,), "named": True, "probability": 0.97}
    ripple_too = {"false": [["torque_ripple", (1,), 0.97]], "lost": [], "open": []}
    missed = spring | {"named": False, "false": [], "lost": ["a"], "open": [["joint_spring", (0,), 0.6]]}
    found = injected_score([spring | ripple_too, missed])
    counts = [found[key] for key in ("named_percent", "false_names", "cases_with_false_name", "lost")]
    assert counts == [50.0, 1, 1, 1]
    assert found["calibration"] == [[0.5, 0.8, 1, 0.6, 1.0], [0.95, 0.99, 2, 0.97, 0.5]]


TIME = np.arange(0.0, 10.0, 0.01)
LOG = {
    "t": TIME, "q1": np.sin(TIME), "q2": np.cos(1.3 * TIME), "i1": np.sin(2.0 * TIME + 1),
    "i2": np.cos(3.1 * TIME),
}  # fmt: skip
COLUMNS = {"time": ["t"], "position": ["q1", "q2"], "current": ["i1", "i2"]}
KNOWN = Known("s", "rad", "", "current", np.array([10.0, 5.0]), COLUMNS)


def test_truth_about_a_log_follows_from_what_was_changed():
    wrong = {
        "t": 1e3 * TIME,
        "q1": np.degrees(LOG["q2"]),
        "q2": np.degrees(LOG["q1"]),
        "i1": -2.0 * LOG["i1"],
    }
    known = altered(KNOWN, LOG, LOG | wrong)
    assert (known.time, known.position, known.columns["position"]) == ("ms", "deg", ["q2", "q1"])
    np.testing.assert_allclose(known.gain, [-5.0, 5.0])
    assert altered(KNOWN, LOG, LOG | {"q1": 0.25 * LOG["q1"]}).position == "?"


@pytest.mark.parametrize(
    ("what", "value", "true"),
    [
        ("unit of position", "rad", True), ("unit of position", "deg", False),
        ("unit of i{number}", "not N m: needs gain", True), ("unit of i{number}", "N m of the joint", False),
        ("direction of gravity", "0.02, 0.00, -1.00 of the base", True),
        ("order of joints", "as numbered", True),
        ("current", "i{number}", True), ("torque", "torque_on", False),
    ],
)  # fmt: skip
def test_guesses_of_init_are_judged(what, value, true):
    unit = value if what == "unit of position" else "rad"
    proposal = {"guesses": [], "gains": [], "columns": COLUMNS, "units": {"position": unit}}
    assert judged({"what": what, "value": value}, proposal, KNOWN) is true


def test_calibration_leaves_out_what_nobody_knows():
    said = [(0.96, True), (0.98, False), (0.999, True), (0.995, None), (0.5, False)]
    rows = calibration([Statement("log", "", probability, true) for probability, true in said])
    assert rows == [["95 to 99 %", 2, 1, 50.0], ["> 99 %", 1, 1, 100.0]]


def test_named_and_false_names_of_concealed_physics_are_counted():
    pytest.importorskip("mujoco")
    from parts.simulator.real_arm import Item
    from parts.simulator.score import score

    def answer(findings=(), servos=(), numbers=()):
        return SimpleNamespace(findings=set(findings), servos=set(servos), numbers=set(numbers))

    delay, mass = Item("delay", (0, 1), {"seconds": 0.02}), Item("mass", (1,), {"factor": 1.5})
    assert score([delay], answer(servos=[("delay", 0), ("delay", 1)]), True).named == (("delay", (0, 1)),)
    half = score([delay], answer(servos=[("delay", 0)]), True)
    assert half.named == half.false == ()
    for numbers in ([("mass", 1)], [("pos", 2)]):  # a mass may be named on the body of a neighbor
        assert score([mass], answer(numbers=numbers), True).named
    assert not score([mass], answer(numbers=[("damping", 1)]), True).named
    items = [Item("cable", (1,), {}), Item("kp", (0,), {})]
    findings = [("joint_spring", 1), ("torque_ripple", 1), ("torque_ripple", 0)]
    scores = score(items, answer(findings, servos=[("kp", 0), ("kp", 1)]), True)
    assert len(scores.named) == 2
    assert scores.false == (("kp", 1), ("torque_ripple", 0))
