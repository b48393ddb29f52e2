"""A diagnosis in words and tables."""

import json
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis import Diagnosis, Finding, Hypothesis, Quantity, Remainder
from exidyn.identification.diagnosis.candidates import KINDS, hypotheses
from exidyn.identification.diagnosis.candidates.curves import NAMES
from exidyn.identification.diagnosis.findings.axes import AXES
from exidyn.identification.diagnosis.findings.diagnosis import Moment
from exidyn.identification.diagnosis.findings.quantities import Formatted, stated, with_interval
from exidyn.identification.diagnosis.findings.residuals import Budget, Change, Share
from exidyn.identification.diagnosis.findings.size import LeftOut, Point, Size
from exidyn.identification.diagnosis.results.budget import NOISE as NOISE_SHARE
from exidyn.identification.diagnosis.results.budget import OTHER
from exidyn.identification.diagnosis.words.diagnosis_file import as_json
from exidyn.identification.diagnosis.words.measures import in_units_of_joints
from exidyn.identification.diagnosis.words.sentences import sentence
from exidyn.identification.diagnosis.words.verdict import verdict
from exidyn.identification.pages.budget import percents
from exidyn.identification.pages.diagnosis_document import report_html, summary

from ...parts.small import two_joints

JOINTS = ("joint1", "joint2", "joint3")
NOISE = np.array([1.0, 0.5, 0.2])
VOCABULARY = (
    "link_inertia payload rotor_inertia base_tilt viscous_friction coulomb_friction friction_asymmetry "
    "stribeck_friction load_dependent_friction nonlinear_viscous_friction temperature_dependent_friction "
    "position_dependent_friction hysteresis spring_balancer joint_spring drive_gain drive_gain_saturation "
    "current_offset torque_ripple current_clipping kinematic_coupling joint_elasticity backlash "
    "encoder_offset time_delay contact_event"
).split()
OUTSIDE = (
    *"hose_spring supply_sag current_crosstalk neighbour_friction axis_misalignment torque_curve".split(),
    *("periodic_disturbance", "gravity_compensation", "warming_friction", *NAMES.values()),
)


def finding(effect="load_dependent_friction", joints=(2,), torque=2.0, **changes) -> Finding:
    made = Finding(
        effect=effect,
        joints=joints,
        parameters={"mu3": Quantity(0.12, 0.006, "1")},
        probability=0.9995,
        torque_rms=np.array([torque if joint in joints else 0.0 for joint in range(3)]),
        held_out=900.0,
        listed=effect not in OUTSIDE,
    )
    return replace(made, **changes)


def other(effect: str, joints: tuple[int, ...], probability: float) -> Hypothesis:
    """What a finding might be instead."""
    return Hypothesis(effect=effect, joints=joints, parameters={}, probability=probability)


def budget(*shares: tuple[float, float, float], noise=0.25, **kinds) -> Budget:
    """Of findings in order, of kinds, of noise, and of nothing for the rest; before 2 N m on every joint."""
    parts = [Share(place, "", 100.0 * np.array(own)) for place, own in enumerate(shares)]
    parts += [Share(None, kind.replace("_", " "), 100.0 * np.array(own)) for kind, own in kinds.items()]
    parts += [Share(None, NOISE_SHARE, np.full(3, 100.0 * noise))] if noise else []
    rest = 100.0 - sum((share.percent for share in parts), np.zeros(3))
    return Budget(np.full(3, 2.0), np.full(3, 1.0), (*parts, Share(None, OTHER, rest)), ("other",))


def diagnosis(*findings: Finding, after=(1.02, 1.0, 1.05), **changes) -> Diagnosis:
    """With noise measured at rest, unless the budget has none."""
    spent = changes.get("budget", budget(*[(0.0, 0.0, 0.31)] * len(findings), velocity=(0.1, 0.1, 0.3)))
    made = Diagnosis(
        name="arm",
        joints=JOINTS,
        torque_units=("N m",) * 3,
        findings=findings,
        runs=("one", "two"),
        held_out=("other",),
        noise=NOISE,
        noise_measured_at_rest=any(share.kind == NOISE_SHARE for share in spent.shares),
        torque_rms_before=NOISE * [1.1, 1.0, 2.7],
        torque_rms_after=NOISE * after,
        torque_rms_filter_hz=25.0,
        budget=spent,
    )
    return replace(made, **changes)


NO_HELD_OUT = {
    "held_out": (), "torque_rms_before": None, "torque_rms_after": None, "torque_rms_filter_hz": None,
}  # fmt: skip


def sliding(one: Diagnosis) -> Diagnosis:
    """The same of an arm whose last joint slides."""
    robot = SimpleNamespace(revolute=np.array([True, True, False]))
    findings = tuple(in_units_of_joints(finding, robot) for finding in one.findings)
    return replace(one, findings=findings, torque_units=("N m", "N m", "N"))


OTHERS = (other("time_delay", (), 0.2), other("backlash", (2,), 0.12))
LEANING = replace(finding("base_tilt", ()), torque_rms=np.array([0.1, 9.0, 0.0]))
MOMENT = Moment("other", 3.2, 3.6, (0, 2), np.array([0.0, -1.0, 0.0]), 31.4)
RIVALS = (other("torque_ripple", (2,), 0.12), other("load_dependent_friction", (1,), 0.06))
SUSPECTED = "log: the positions of joint1 and joint2 are exchanged: give them the other way"
UNMEASURED = {**NO_HELD_OUT, "budget": budget(noise=0.0)}
SAID = {
    "number, unit, joint": (
        diagnosis(finding()),
        ["Joint 3 has load-dependent friction", "0.120 ± 0.012 N m per N m", "31 % of the squared residual",
         "2.00 -> 1.00 N m (10.0 -> 5.00 x noise)", "probability above 99.9 %"],
    ),
    "the joint whose residual it explains": (
        diagnosis(LEANING, budget=budget((0.94, 0.02, 0.96))),
        ["explains 94 % of the squared residual of joint 1.", "Held-out residual of joint 1:"],
    ),
    "nearly all": (diagnosis(finding(), budget=budget((0.0, 0.0, 0.997))), ["It explains 99.7 %"]),
    "rivals and the run that settles it": (
        diagnosis(finding(alternatives=RIVALS, probability=0.82)),
        ["probability 82 %", "torque ripple of joint 3 (12 %) and load-dependent friction of joint 2 (6 %)",
         "settle it: a run with a body of known mass on the flange (exidyn excite --mass)."],
    ),
    "small and not confirmed": (
        diagnosis(finding(torque=0.02, held_out=-3.0)),
        ["It is small, 0.10 x noise", "predicted no better with it"],
    ),
    "name undecided": (
        diagnosis(undecided=(finding("joint_spring", probability=0.65, alternatives=OTHERS),)),
        ["joint spring (65 %), time delay of the arm (20 %) or backlash (12 %)", "excite --kind sweeps"],
    ),
    "shown by one joint": (
        diagnosis(undecided=(finding("base_tilt", (), probability=0.95, alone=True),)),
        ["The arm: the missing effect is base tilt (95 %), but only one joint shows it"],
    ),
    "as much without a name": (
        diagnosis(undecided=(finding(probability=0.4, unnamed=True),)),
        ["or something that acts like it: the unexplained residual there is as large"],
    ),
    "no name": (
        diagnosis(remainders=(Remainder(1, 2.14, 0.999, "position and velocity"),)),
        ["Something is missing, and it is none of the effects", "1.00 N m (2.00 x its noise)",
         "depends on position and velocity"],
    ),
    "one more without a name": (
        diagnosis(finding(), remainders=(Remainder(1, 2.14, 0.999, "position"),)),
        ["Something more is missing"],
    ),
    "a contact": (
        diagnosis(moments=(MOMENT,)),
        ["other, 3.20 to 3.60 s: joints 1 and 3", "a force of 31 N acted on the flange along (0.00, -1.00,"],
    ),
    "one joint is no force on the flange": (
        diagnosis(moments=(Moment("run_2", 1.0, 1.3, (1,), np.full(3, np.nan), np.nan),)),
        ["run_2, 1.00 to 1.30 s: joint 2"],
    ),
    "nothing": (diagnosis(), ["Nothing is missing. With parameters"]),
    "nothing, above the noise": (diagnosis(after=(1.0, 1.0, 1.8)), ["the worst is joint 3 with 1.80 x"]),
    "nothing, not held out": (diagnosis(**NO_HELD_OUT), ["as far as the fitted runs show"]),
    "nothing, without a noise level": (
        diagnosis(**UNMEASURED),
        ["No missing effect was found", "It is 1.00 N m on joint 1; noise was not measured at rest"],
    ),
    "more than noise": (
        diagnosis(finding(), after=(1.6, 1.0, 1.0)),
        ["More than noise is left on joint 1 (1.60 x noise)"],
    ),
    "a mistake of the input": (
        diagnosis(finding(), suspicions=(SUSPECTED,)),
        ["Check the input first: Log: the positions of joint1", "holds only if the input is right"],
    ),
    "warnings, and a run's name": (
        diagnosis(finding(), runs=("run_1",), warnings=("run_1: 3 gaps", "no payload")),
        ["run_1: 3 gaps.", "No payload."],
    ),
}  # fmt: skip
"""What a diagnosis is, and what its verdict must say: names, numbers, units and what to do."""


@pytest.mark.parametrize("case", SAID)
def test_the_verdict_says_what_was_diagnosed(case):
    one, said = SAID[case]
    text = " ".join(verdict(one))
    for words in said:
        assert words in text
    nothing = case.startswith("nothing")
    assert ("othing is missing" in text or "No missing effect" in text) == nothing
    assert ("force" in text) == (case == "a contact")
    assert ("It is small" in text) == (case == "small and not confirmed")


@pytest.mark.parametrize(("gear_ratio", "turning"), [(1.0, "the joint"), (160.0, "its motor")])
def test_ripple_turns_with_the_joint_where_no_gear_ratio_is_given(gear_ratio, turning):
    model = two_joints.model()
    robot = replace(model.robot, gear_ratio=np.full(model.robot.dof, gear_ratio))
    candidate = next(iter(hypotheses("torque_ripple", replace(model, robot=robot))))
    numbers = {"Rcos2_1": Quantity(0.1, 0.01, "N m"), "harmonic": Quantity(2.0, np.nan, "1")}
    one = finding("torque_ripple", (0,), parameters=numbers, geared=stated(candidate)["geared"])
    assert f"2 times per turn of {turning}:" in sentence(one, JOINTS)


@pytest.mark.parametrize(("std", "said"), [(0.05, "relaxed at -0.40 ± 0.20 rad"), (300.0, "")])
def test_a_spring_is_relaxed_at_an_angle_only_where_that_is_known(std, said):
    numbers = {"Ks3": Quantity(0.5, 0.01, "N m/rad"), "Ts3": Quantity(0.2, std, "N m")}
    text = sentence(finding("joint_spring", parameters=numbers), JOINTS)
    assert "0.500 ± 0.020 N m/rad" in text
    assert said in text
    assert ("relaxed" in text) == bool(said)


def test_every_word_of_the_vocabulary_has_a_sentence_and_a_picture():
    assert set(KINDS) == {*VOCABULARY, *OUTSIDE}
    for kind in KINDS.values():
        assert kind.sentence
        assert len(kind.drawn_against) == 2
        assert set(kind.drawn_against) <= set(AXES)
        assert set(kind.mistaken_for) <= set(VOCABULARY)


@pytest.mark.parametrize("effect", KINDS)
def test_what_the_search_asks_about_can_be_put_in_words(effect):
    model = two_joints.model()
    for candidate in [*hypotheses(effect, model)][:3]:
        units = zip(candidate.names, candidate.units, strict=True)
        values = {name: Quantity(-0.5, 0.1, unit) for name, unit in units}
        shape = {name: Quantity(value, np.nan, "1") for name, value in candidate.shape.items()}
        one = replace(finding(), **stated(candidate) | {"parameters": values | shape})
        text = sentence(one, model.robot.joints)
        assert not set("{}[]?") & set(text)
        assert any(letter.isdigit() for letter in text)
        # What is fitted of a balancer has the lever in it, which is not known.
        if effect != "spring_balancer":
            assert text != sentence(replace(one, parameters={}), model.robot.joints)


LOADED = Size(
    2, 0.05, 0.004, "size of the load",
    (Point("smallest", 0.0, 0.0, 0.0), Point("usual", 0.85, 0.19, 0.024), Point("largest", 1.1, 0.29, 0.03)),
)  # fmt: skip


def collinear(**changes) -> Finding:
    """Its preload is not known beside its growth; its torque is."""
    numbers = {"mu3": Quantity(0.61, 0.27, "1"), "preload": Quantity(0.7771, 0.64, "N m")}
    missing = {"preload": LeftOut("mu3")}
    return replace(finding(parameters=numbers, size=LOADED, left_out=missing), **changes)


def test_what_is_not_determined_is_not_given_and_the_torque_stands_instead():
    one = diagnosis(collinear())
    first, second, *_ = verdict(one)
    assert "grows by 0.6 ± 0.5 N m per N m" in first
    assert "0.19 ± 0.05 N m at 0.85 N m (usual) and 0.29 ± 0.06 N m at 1.1 N m (largest)." in first
    assert "preload is not given because these runs cannot separate it from mu3." in second
    page = summary(one)
    assert "0.7771" not in page
    assert "0.78" not in page
    rows = [line.split() for line in page.splitlines()]
    assert ["0.85", "N", "m", "(usual)", "0.1900", "0.047", "N", "m"] in rows
    [row] = as_json(one)["findings"]
    assert row["size"]["points"][1] == {"at": 0.85, "torque": 0.19, "std": 0.024, "which": "usual"}
    assert (row["size"]["joint"], row["size"]["over"]) == (3, "size of the load")
    assert row["left_out"] == {"preload": {"beside": "mu3", "effect": ""}}


def test_what_is_not_determined_is_not_given():
    missing = {"mu3": LeftOut("Fc3", "coulomb_friction"), "preload": LeftOut()}
    first, second, *_ = verdict(diagnosis(collinear(left_out=missing)))
    assert first.startswith("Joint 3 has load-dependent friction; over the size of the load,")
    assert "mu3 is not given because these runs cannot separate it from Fc3 of Coulomb friction" in second
    first = verdict(diagnosis(collinear(size=replace(LOADED, change=True))))[0]
    assert first.count("; relative to that at a size of the load of 0 N m") == 1
    unknown = replace(LOADED, points=(Point("largest", 1.1, 0.29, 0.2),))
    first = verdict(diagnosis(collinear(size=unknown)))[0]
    assert "; it gives 0.050 ± 0.008 N m, root mean square, that no other parameter can absorb." in first
    assert "0.29" not in first


def test_the_report_draws_the_torque_with_its_band():
    curve = tuple(Point("", x, 0.3 * x, 0.02) for x in (0.1, 0.5, 1.0))
    page = report_html(diagnosis(collinear(size=replace(LOADED, curve=curve))))
    assert "Torque of the effect over size of the load" in page
    assert 'class="sure"' in page
    assert "Torque of the effect over" not in report_html(diagnosis(collinear()))


@pytest.mark.parametrize(
    ("value", "std", "message"),
    [
        (0.11679, 0.0004, "0.1168 ± 0.0008"),
        (45.3, 6.0, "45 ± 12"),
        (-0.02, 1.0, "0.0 ± 2.0"),
        (1234.5, 51.0, "1230 ± 100"),
        (0.167, np.nan, "0.167"),
        (123456.0, 1e-3, "123500 ± 100"),
    ],
)
def test_numbers_have_the_digits_of_their_interval(value, std, message):
    assert with_interval(value, std) == message


def test_numbers_change_unit_sign_and_word_and_joints_have_names():
    zero = Formatted(-0.0125, 0.0005, "rad")
    assert f"{zero:size mrad}" == "12.5 ± 1.0 mrad"
    assert f"{zero:beyond|short of}" == "short of"
    assert f"{Formatted(0.1, np.nan, '1'):%}" == "10 %"
    assert sentence(finding(), ("a1", "a2", "elbow")).startswith("Joint 3 (elbow) has")
    assert sentence(finding(), ("a1", "a2", "joint_a3")).startswith("Joint 3 has")


def test_a_body_of_unknown_mass_is_reported_by_its_moments():
    numbers = {name: Quantity(value, 0.01, "kg m") for name, value in (("MX", 0.4), ("MY", 0.0), ("MZ", 1.2))}
    for mass, said in (
        (Quantity(1.0, 5.0, "kg"), "first moments are (0.4, 0, 1.2) kg m"),
        (Quantity(4.0, 0.1, "kg"), "center of mass at (100, 0, 300) mm"),
    ):
        assert said in sentence(finding("payload", (), parameters=numbers | {"M": mass}), JOINTS)


def test_multiples_of_noise_are_reported_only_where_it_was_measured():
    guessed = diagnosis(finding(), budget=budget((0.0, 0.0, 0.31), noise=0.0), after=(1.9, 1.0, 1.05))
    page = summary(guessed)
    assert "x noise" not in page
    assert "Sensor noise was not measured at rest" in " ".join(page.split())
    assert "x noise" in summary(diagnosis(finding()))
    assert "x noise" not in " ".join(verdict(replace(guessed, findings=(), budget=budget(noise=0.0))))


def test_the_verdict_comes_first_and_the_budget_adds_up_to_a_hundred():
    lines = summary(diagnosis(finding())).splitlines()
    start = lines.index("Residual by cause")
    assert lines.index("Verdict") < start
    shares = re.findall(r"(\d+) % \([\d.]+\)$", "\n".join(lines[start:]), flags=re.M)
    assert sum(map(int, shares)) == 100
    table = as_json(diagnosis(finding()))["budget"]
    np.testing.assert_allclose(sum(np.array(one["percent"]) for one in table["shares"]), 100.0)
    assert table["shares"][0]["finding"] == 0
    assert table["before_rms"] == [2.0] * 3


def test_the_budget_is_whole_per_cents_with_small_kinds_in_one_line():
    shares = np.array([[1 / 3], [1 / 3], [1 / 3]])
    assert sorted(percents(shares)[:, 0]) == [33, 33, 34]
    assert list(percents(np.array([[0.004], [0.996]]))[:, 0]) == [0, 100]
    page = summary(diagnosis(budget=budget(load=(0.004,) * 3, time=(0.002,) * 3, position=(0.0, 0.0, 0.2))))
    assert "other kinds, less than 1 % each" in page
    assert "depends on load" not in page
    assert "depends on position" in page


def test_candidates_are_listed_with_what_each_alone_would_change():
    every = tuple(Change("backlash", (place % 3,), 1, -30.0 + place, 4.0, 9.0) for place in range(12))
    page = summary(diagnosis(changes=every))
    assert page.count("Backlash of joint") == 10
    assert re.search(r"Backlash of joint 1  Joint 2 +-30\.0     4\.0\n", page)
    table = as_json(diagnosis(changes=every))["changes"]
    assert len(table) == 12
    assert (table[0]["joints"], table[0]["joint"], table[0]["std_percent"]) == ([1], 2, 4.0)


@pytest.mark.parametrize(
    ("effect", "parameters", "message"),
    [
        ("friction_asymmetry", {"Fa3": "N m", "Fva3": "N m s/rad"}, "0.120 ± 0.012 N above the mean of both"),
        ("viscous_friction", {"Fv3": "N m s/rad"}, "0.120 ± 0.012 N s/m higher"),
        ("joint_spring", {"Ks3": "N m/rad"}, ": 0.120 ± 0.012 N/m"),
        ("rotor_inertia", {"Ia3": "kg m^2"}, "0.120 ± 0.012 kg larger"),
        ("backlash", {"gap": "rad"}, ": 120 ± 12 mm"),
        ("load_dependent_friction", {"mu3": "1"}, "0.120 ± 0.012 N per N that"),
    ],
)
def test_joints_that_slide_have_units_of_their_own(effect, parameters, message):
    numbers = {name: Quantity(0.12, 0.006, unit) for name, unit in parameters.items()}
    one = diagnosis(finding(effect, parameters=numbers))
    page = " ".join(summary(sliding(one)).split())
    assert message in page
    assert "2.00 -> 1.00 N (10.0" in page
    units = [quantity["unit"] for quantity in as_json(sliding(one))["findings"][0]["parameters"].values()]
    assert not any("N m" in unit or "rad" in unit for unit in units)
    assert message not in " ".join(summary(one).split())


def test_the_page_of_text_has_findings_intervals_and_ratios():
    lines = summary(diagnosis(finding())).splitlines()
    heading = lines.index("Load-dependent friction of joint 3")
    assert lines[heading + 2].split() == ["mu3", "0.1200", "0.012"]
    joint = next(line for line in lines[heading:] if line.startswith("Joint 3 "))
    # noise, before and after by the budget, and the two over noise
    assert joint.split()[4:] == ["0.2000", "2.000", "1.000", "10.00", "5.000"]
    assert max(map(len, lines)) <= 80
    assert "Held out:         none" in summary(diagnosis(finding(), **NO_HELD_OUT))


def test_what_the_vocabulary_has_no_name_for_is_reported_and_unexplained():
    one = as_json(diagnosis(finding("current_crosstalk"), finding()))
    assert [named["effect"] for named in one["findings"]][0] == "current_crosstalk"
    assert one["unexplained"]
    assert not as_json(diagnosis(finding()))["unexplained"]
    assert as_json(diagnosis(remainders=(Remainder(0, 2.0, 1.0, "time"),)))["unexplained"]


def test_a_plain_diagnosis_is_json_without_nan():
    one = finding(parameters={"mu3": Quantity(0.12, np.nan, "1")}, held_out=np.nan)
    undecided = (finding("joint_spring", probability=0.65),)
    left = (Remainder(0, 2.0, 1.0, "time"),)
    made = diagnosis(one, undecided=undecided, remainders=left, moments=(MOMENT,))
    table = json.loads(json.dumps(as_json(made), allow_nan=False))
    assert table["findings"][0]["parameters"]["mu3"] == {"value": 0.12, "std": None, "unit": "1"}
    assert table["findings"][0]["held_out"] is None
    assert table["remainders"][0]["joint"] == 1
    assert (table["undecided"][0]["effect"], table["undecided"][0]["joints"]) == ("joint_spring", [3])
    assert (table["moments"][0]["joints"], table["moments"][0]["force"]) == ([1, 3], 31.4)
    assert table["verdict"][0].startswith("Joint 3 has load-dependent friction")
