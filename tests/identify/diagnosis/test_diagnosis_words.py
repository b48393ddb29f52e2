"""A diagnosis in words and tables."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis import Diagnosis, Finding, Hypothesis, Quantity, Remainder
from exidyn.identification.diagnosis.candidates import KINDS, hypotheses
from exidyn.identification.diagnosis.candidates.curves import CURVES
from exidyn.identification.diagnosis.findings.adequacy import Adequacy, Misfit
from exidyn.identification.diagnosis.findings.axes import AXES
from exidyn.identification.diagnosis.findings.beliefs import Beliefs, Departure
from exidyn.identification.diagnosis.findings.diagnosis import Moment
from exidyn.identification.diagnosis.findings.evidence import Budget, Share
from exidyn.identification.diagnosis.findings.quantities import Formatted, stated, with_interval
from exidyn.identification.diagnosis.findings.size import LeftOut, Point, Size
from exidyn.identification.diagnosis.results.budget import NOISE as NOISE_SHARE
from exidyn.identification.diagnosis.results.budget import OTHER
from exidyn.identification.diagnosis.words.diagnosis_file import as_json
from exidyn.identification.diagnosis.words.limits import warnings
from exidyn.identification.diagnosis.words.measures import in_units_of_joints
from exidyn.identification.diagnosis.words.sentences import sentence
from exidyn.identification.diagnosis.words.verdict import details, verdict
from exidyn.identification.document.text import brief_text, text
from exidyn.identification.pages.diagnosis_document import diagnosis_document, report_html
from exidyn.identification.pages.diagnosis_table import findings_table
from exidyn.identification.pages.shown import Shown

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
    *(
        "periodic_disturbance",
        "gravity_compensation",
        "warming_friction",
        *(name for name, _ in CURVES.values()),
    ),
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


def summary(one: Diagnosis) -> str:
    """The whole page as text."""
    return text(diagnosis_document(Shown(one)))


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
MOMENT = Moment("other", 3.2, 3.6, (0, 2), np.array([0.0, -1.0, 0.0]), 31.4)
RIVALS = (other("torque_ripple", (2,), 0.12), other("load_dependent_friction", (1,), 0.06))
SUSPECTED = "log: the positions of joint1 and joint2 are exchanged: give them the other way"
UNMEASURED = {**NO_HELD_OUT, "budget": budget(noise=0.0)}
WIDE = replace(finding("coulomb_friction", (0,)), torque_rms=np.array([1.0, 0.0, 0.0]))
SHAKY = finding("joint_spring", probability=0.65, alternatives=OTHERS, proven=False)
SPRING = replace(
    finding("joint_spring", probability=0.86, alternatives=(other("spring_balancer", (2,), 0.14),)),
    family="position", family_probability=0.9995,
)  # fmt: skip
SHARED = {"budget": budget((0.0, 0.0, 0.31), (0.5, 0.5, 0.0))}


def inadequate(*failing: int, misfits=()) -> Diagnosis:
    shares, alone = np.array([0.45, 0.3, 0.05]), np.array([0.04, 0.05, 0.04])
    return diagnosis(finding(), adequacy=Adequacy(shares, alone, 0.3, failing, misfits))


DEPARTURE = Departure("drive gain", 2, "gain3", 5.0, 10.0, 11.25, "N m/A")
MOMENTS = Departure("link", 1, "MX2", 9.0, 0.8, 1.2, "kg m")
LEFT = (Remainder(1, 2.14, 0.999, "position and velocity"),)


def believed(*findings: Finding, conditional=(), departures=()) -> Diagnosis:
    """With both beliefs: free bodies absorb the conditional findings."""
    rms = np.full(3, 0.6), np.full(3, 0.47)
    return diagnosis(*findings, beliefs=Beliefs(conditional, (MOMENTS,), departures, *rms))


GAIN_OFF = "The drive gain of joint 3 is 12.5 % above its nominal value: 5.0 of its stated standard "
LIFT = "Joint 3 has load-dependent friction: Coulomb friction grows by 0.120 ± 0.012 N m per N m"
SAID = {
    "the one that explains most": (
        diagnosis(finding(), WIDE, budget=budget((0.0, 0.0, 0.31), (0.9, 0.0, 0.0))),
        "Joint 1 has", "joint 1 falls from 2.00", "identify",
    ),
    "an undecided one that explains most": (
        diagnosis(WIDE, undecided=(SPRING,), budget=budget((0.3, 0.0, 0.0), (0.0, 0.0, 0.97))),
        "Joint 3 has a torque that depends on the joint's position (above 99.9 %): joint spring 86 % or",
        "joint 3", "tell joint spring from spring balancer by",
    ),
    "one that explains nothing": (
        diagnosis(finding(), budget=budget((0.0, 0.0, 0.009))),
        "No missing effect is certain: no finding explains", "largest residual is 5.00 x noise, on", "RUN",
    ),
    "not held out": (
        diagnosis(finding(), **NO_HELD_OUT, budget=replace(budget((0.0, 0.0, 0.31)), held_out=())),
        LIFT, "No run was held out", "--validate RUN",
    ),
    "worse on a joint": (
        diagnosis(finding(), budget=replace(budget((0.0, 0.0, 0.31)), after_rms=np.array([2.2, 2.0, 1.0]))),
        LIFT, "; joint 1 up to 10 % more.", "identify",
    ),
    "no name": (diagnosis(remainders=LEFT), "Something is missing that is none of", "5.00 x", "exidyn view"),
    "a contact": (
        diagnosis(moments=(MOMENT,)), "other, 3.20 to 3.60 s: joints 1 and 3 differ", "largest", "identify"
    ),
    "nothing": (
        diagnosis(budget=replace(budget(), after_rms=1.05 * NOISE)),
        "Nothing is missing: the residual of every joint is at the noise floor.", "1.05 x noise", "identify",
    ),
    "nothing, within tolerances": (
        replace(believed(), budget=replace(budget(), after_rms=NOISE)),
        "Nothing is missing, with parameters and drive gains within their tolerances", "1.00 x noise", "",
    ),
    "nothing but noise that is not known": (
        diagnosis(**UNMEASURED), "No missing effect is certain: the residual depends on no recorded",
        "1.00 N m, on joint 3; noise was not measured at rest", "--validate",
    ),
    "a mistake of the input": (
        diagnosis(finding(), suspicions=(SUSPECTED,)),
        "Check the input first: Log: the positions of joint1", "joint 3 falls", "exidyn init LOG",
    ),
    "joints that do not fit": (
        inadequate(0, 1),
        "Check the input first (columns, units, description): joints 1 and 2 do not fit as correct "
        "recordings do; their residuals are 45 % and 30 % of their torques; each fits by itself (4 %",
        "", "exidyn init LOG",
    ),
    "a joint that does not fit": (
        inadequate(0, misfits=(Misfit("one", 3.0, 4.5, 0),)),
        "Joint 1 does not fit as correct recordings do: its residual is 45 % of its torque, most of it "
        "in one at 3.00 to 4.50 s; no effect is named there.", "", "exidyn view",
    ),
    "a belief": (believed(finding(), conditional=(0,)), f"With the bodies as described, j{LIFT[1:]}", "", ""),
    "a gain": (
        believed(departures=(DEPARTURE,)), GAIN_OFF, "", "",
    ),
}  # fmt: skip
"""What a diagnosis is, and what its three sentences must say."""


@pytest.mark.parametrize("case", SAID)
def test_three_sentences_state_the_cause_the_gain_and_the_next_command(case):
    one, *said = SAID[case]
    sentences = verdict(one)
    assert [words for words, text in zip(said, sentences, strict=True) if words not in text] == []
    assert sentences[0].startswith(said[0])
    assert sentences[2].startswith("Next: ")
    assert ("Nothing is missing" in sentences[0]) == (case in ("nothing", "nothing, within tolerances"))


def rows_of(one: Diagnosis) -> list[list[str]]:
    return [[str(cell) for cell in row] for row in findings_table(one).rows]


def test_the_table_has_every_joint_and_every_finding_with_its_own_numbers():
    spring = replace(SHAKY, torque_rms=np.array([1.0, 1.0, 0.0]))
    one = diagnosis(finding(), undecided=(spring,), remainders=LEFT, **SHARED)
    open_ = "undecided: joint spring 65 %, time delay of the arm 20 % or backlash 12 % (not proven)"
    assert rows_of(one) == [
        ["joint1", "2.00 -> 1.00", open_, "", "50 %"],
        ["joint2", "2.00 -> 1.00", "undecided, as on joint1", "", "50 %"],
        ["", "", "unexplained, depends on position and velocity", "99.9 %", ""],
        ["joint3", "2.00 -> 1.00", "load-dependent friction: 0.120 ± 0.012", "> 99.9 %", "31 %"],
    ]
    assert rows_of(diagnosis())[0] == ["joint1", "2.00 -> 1.00", "-", "", ""]
    assert rows_of(replace(diagnosis(), joints=("a" * 11, "b", "c")))[0][0] == "1"


def test_a_finding_without_a_determined_number_has_the_size_of_its_torque():
    missing = {"mu3": LeftOut("Fc3", "coulomb_friction"), "preload": LeftOut()}
    assert rows_of(diagnosis(collinear(left_out=missing)))[2][2] == "load-dependent friction: 0.29 ± 0.06 N m"
    assert rows_of(inadequate(0, 1))[2][2:4] == ["candidate: load-dependent friction", ""]
    unknown = replace(LOADED, points=(), beside_rms=0.05, beside_std=0.05)
    assert rows_of(diagnosis(collinear(left_out=missing, size=unknown)))[2][2] == "load-dependent friction"


def test_warnings_are_sentences_that_are_said_once():
    one = replace(
        believed(finding(), conditional=(0,), departures=(DEPARTURE,)),
        runs=("run_1",), suspicions=(SUSPECTED,), warnings=("run_1: 3 gaps", "no payload", "no payload"),
    )  # fmt: skip
    assert warnings(one, verdict(one)) == [
        "Free bodies absorb load-dependent friction of joint 3, with first moment MX2 by 9.0 standard "
        "deviations off the description; residual of joint 3: 0.470 instead of 0.600 N m.",
        f"{GAIN_OFF}deviations.",
        "run_1: 3 gaps.",
        "No payload.",
    ]


def test_the_short_page_is_read_at_a_glance():
    one = diagnosis(finding(), undecided=(SPRING,), warnings=("no payload",), **SHARED)
    lines = brief_text(diagnosis_document(Shown(one, folder="out")), 25).splitlines()
    assert len(lines) <= 25
    assert max(map(len, lines)) <= 80
    assert lines[-1] == "- No payload."
    assert any(line.startswith("- Next: ") for line in lines)
    assert "Residual by cause" in summary(one)


def test_details_have_the_probability_what_is_excluded_and_how_to_decide():
    rivals = diagnosis(finding(alternatives=RIVALS, probability=0.82))
    said = " ".join(details(rivals, rivals.findings[0]))
    assert "Probability 82 %." in said
    assert "tell load-dependent friction from torque ripple by a run with a body of known mass on the" in said


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
    page = summary(one)
    assert "preload is not given because these runs cannot separate it from mu3." in " ".join(page.split())
    assert "0.7771" not in page
    assert "0.78" not in page
    [row] = as_json(one)["findings"]
    assert row["size"]["points"][1] == {"at": 0.85, "torque": 0.19, "std": 0.024, "which": "usual"}
    assert (row["size"]["joint"], row["size"]["over"]) == (3, "size of the load")
    assert row["left_out"] == {"preload": {"beside": "mu3", "effect": ""}}
    both = collinear(left_out={"mu3": LeftOut("Fc3", "coulomb_friction"), "preload": LeftOut()})
    page = " ".join(summary(diagnosis(both)).split())
    assert "mu3 is not given because these runs cannot separate it from Fc3 of Coulomb friction" in page
    assert "Over the size of the load, its torque against the motion is" in page


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
    units = [quantity["unit"] for quantity in as_json(sliding(one))["findings"][0]["parameters"].values()]
    assert not any("N m" in unit or "rad" in unit for unit in units)
    assert message not in " ".join(summary(one).split())


def test_the_page_of_text_has_findings_intervals_and_ratios():
    lines = summary(diagnosis(finding())).splitlines()
    assert ["mu3", "0.1200", "0.012"] in [line.split() for line in lines]
    assert sum("baseline 2.00 N m, with findings 1.00 N m" in line for line in lines) == 3
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
