"""A diagnosis in words, tables and answers."""

import json
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis import Diagnosis, Finding, Hypothesis, Quantity, Remainder
from exidyn.identification.diagnosis.candidates import KINDS, hypotheses
from exidyn.identification.diagnosis.candidates.curves import NAMES
from exidyn.identification.diagnosis.findings.diagnosis import Moment
from exidyn.identification.diagnosis.findings.quantities import Formatted, stated, with_interval
from exidyn.identification.diagnosis.findings.residuals import Budget, Change, Share
from exidyn.identification.diagnosis.findings.size import LeftOut, Point, Size
from exidyn.identification.diagnosis.results.budget import NOISE as NOISE_SHARE
from exidyn.identification.diagnosis.results.budget import OTHER
from exidyn.identification.diagnosis.words.diagnosis_file import answer, as_json
from exidyn.identification.diagnosis.words.measures import in_units_of_joints
from exidyn.identification.diagnosis.words.sentences import direction, moment_sentence, sentence
from exidyn.identification.diagnosis.words.verdict import verdict
from exidyn.identification.pages.budget import percents
from exidyn.identification.pages.diagnosis_document import report_html, summary
from exidyn.identification.pages.profiles import AXES

from ...parts.small import two_joints


def plain(one: Diagnosis) -> dict:
    """The table of its file."""
    return as_json(one)


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
    "hose_spring",
    "supply_sag",
    "current_crosstalk",
    "neighbour_friction",
    "axis_misalignment",
    "periodic_disturbance",
    "gravity_compensation",
    "warming_friction",
    *NAMES.values(),
    "torque_curve",
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


def test_a_finding_is_reported_with_number_unit_joint_and_what_was_gained():
    first, second, *_ = verdict(diagnosis(finding()))
    assert first == (
        "Joint 3 has load-dependent friction: Coulomb friction grows by 0.120 ± 0.012 N m per N m that the "
        "gear transmits. It explains 31 % of the squared residual of joint 3. Held-out residual of joint 3: "
        "2.00 -> 1.00 N m (10.0 -> 5.00 x noise)."
    )
    assert second.startswith(
        "Load-dependent friction of joint 3: probability above 99.9 %. Excluded (each less than 1 % "
        "probable):"
    )


def test_what_several_joints_feel_is_reported_of_the_one_whose_misfit_it_explains():
    leaning = replace(finding("base_tilt", ()), torque_rms=np.array([0.1, 9.0, 0.0]))
    one = diagnosis(leaning, budget=budget((0.94, 0.02, 0.96)))
    assert "It explains 94 % of the squared residual of joint 1." in verdict(one)[0]
    assert "Held-out residual of joint 1:" in verdict(one)[0]


def test_what_explains_nearly_all_is_reported_in_plain_per_cent():
    one = diagnosis(finding(), budget=budget((0.0, 0.0, 0.997)))
    assert "It explains 99.7 % of the squared residual of joint 3." in verdict(one)[0]


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


def test_what_the_vocabulary_has_no_name_for_is_reported_to_people_and_unexplained_in_an_answer():
    one = diagnosis(finding("current_crosstalk"), finding())
    given = answer(one)
    assert [named["effect"] for named in given["findings"]] == ["load_dependent_friction"]
    assert given["unexplained"]
    assert [named["effect"] for named in plain(one)["findings"]][0] == "current_crosstalk"
    assert not answer(diagnosis(finding()))["unexplained"]


@pytest.mark.parametrize("effect", KINDS)
def test_what_the_search_asks_about_can_be_put_in_words(effect):
    model = two_joints.model()
    for candidate in [*hypotheses(effect, model)][:3]:
        values = {
            name: Quantity(-0.5, 0.1, unit)
            for name, unit in zip(candidate.names, candidate.units, strict=True)
        }
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
    assert (
        "; over the size of the load, its torque against the motion is 0 N m at 0 N m (smallest), 0.19 "
        "± 0.05 N m at 0.85 N m (usual) and 0.29 ± 0.06 N m at 1.1 N m (largest)."
    ) in first
    assert "preload is not given because these runs cannot separate it from mu3." in second
    page = summary(one)
    assert "0.7771" not in page
    assert "0.78" not in page
    rows = [line.split() for line in page.splitlines()]
    assert ["0.85", "N", "m", "(usual)", "0.1900", "0.047", "N", "m"] in rows
    assert "torque against the motion at a size of the load of" in page


def test_without_any_number_that_is_determined_the_effect_and_its_torque_are_given():
    missing = {"mu3": LeftOut("Fc3", "coulomb_friction"), "preload": LeftOut()}
    first, second, *_ = verdict(diagnosis(collinear(left_out=missing)))
    assert first.startswith("Joint 3 has load-dependent friction; over the size of the load,")
    assert "mu3 is not given because these runs cannot separate it from Fc3 of Coulomb friction" in second
    assert (
        "preload is not given because these runs do not determine it together with all other parameters."
        in second
    )


def test_torque_over_the_first_point_is_called_so_and_what_is_not_known_either_is_not_given():
    changing = replace(LOADED, change=True)
    first = verdict(diagnosis(collinear(size=changing)))[0]
    assert first.count("; relative to that at a size of the load of 0 N m") == 1
    unknown = replace(LOADED, points=(Point("largest", 1.1, 0.29, 0.2),))
    first = verdict(diagnosis(collinear(size=unknown)))[0]
    assert "; it gives 0.050 ± 0.008 N m, root mean square, that no other parameter can absorb." in first
    assert "0.29" not in first


def test_the_report_draws_the_torque_with_its_band():
    curve = tuple(Point("", x, 0.3 * x, 0.02) for x in (0.1, 0.5, 1.0))
    page = report_html(diagnosis(collinear(size=replace(LOADED, curve=curve))))
    assert "Torque of the effect over size of the load" in page
    assert "torque against the motion [N m]" in page
    assert 'class="sure"' in page
    assert "Torque of the effect over" not in report_html(diagnosis(collinear()))


def test_the_file_has_the_size_with_units_and_what_is_not_given():
    [row] = plain(diagnosis(collinear()))["findings"]
    assert row["size"]["points"][1] == {"at": 0.85, "torque": 0.19, "std": 0.024, "which": "usual"}
    assert (row["size"]["joint"], row["size"]["over"]) == (3, "size of the load")
    assert row["left_out"] == {"preload": {"beside": "mu3", "effect": ""}}
    [row] = plain(diagnosis(finding()))["findings"]
    assert row["size"] is None


def test_a_name_that_is_not_known_is_still_reported():
    assert sentence(finding("gear_song", parameters={}), JOINTS) == "Joint 3: gear song"


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


def test_numbers_change_unit_sign_and_word():
    zero = Formatted(-0.0125, 0.0005, "rad")
    assert f"{zero:size mrad}" == "12.5 ± 1.0 mrad"
    assert f"{zero:beyond|short of}" == "short of"
    assert f"{Formatted(0.1, np.nan, '1'):%}" == "10 %"


def test_a_body_of_unknown_mass_is_reported_by_its_moments():
    numbers = {name: Quantity(value, 0.01, "kg m") for name, value in (("MX", 0.4), ("MY", 0.0), ("MZ", 1.2))}
    light = numbers | {"M": Quantity(1.0, 5.0, "kg")}
    heavy = numbers | {"M": Quantity(4.0, 0.1, "kg")}
    assert "first moments are (0.4, 0, 1.2) kg m" in sentence(
        finding("payload", (), parameters=light), JOINTS
    )
    assert "center of mass at (100, 0, 300) mm" in sentence(finding("payload", (), parameters=heavy), JOINTS)


def test_joints_are_numbers_with_names_where_those_state_more():
    assert sentence(finding(), ("a1", "a2", "elbow")).startswith("Joint 3 (elbow) has")
    assert sentence(finding(), ("a1", "a2", "joint_a3")).startswith("Joint 3 has")


def test_nothing_is_reported_plainly_and_only_where_it_is_true():
    assert verdict(diagnosis())[0].startswith("Nothing is missing. With parameters")
    worse = verdict(diagnosis(after=(1.0, 1.0, 1.8)))[0]
    assert "But it exceeds the noise floor; the worst is joint 3 with 1.80 x noise" in worse
    assert "as far as the fitted runs show" in verdict(diagnosis(**NO_HELD_OUT))[0]
    unmeasured = verdict(diagnosis(**NO_HELD_OUT, budget=budget(noise=0.0)))[0]
    assert unmeasured.startswith("No missing effect was found: the residual depends on no recorded quantity")
    assert "It is 1.00 N m on joint 1; noise was not measured at rest" in unmeasured


@pytest.mark.parametrize(
    "there",
    [
        {"undecided": (finding(probability=0.6),)},
        {"remainders": (Remainder(1, 2.14, 0.999, "position"),)},
        {"moments": (Moment("other", 3.2, 3.6, (0, 2), np.array([0.0, -1.0, 0.0]), 31.4),)},
    ],
    ids=["undecided", "remainder", "moment"],
)
def test_nothing_is_not_reported_where_something_is(there):
    text = " ".join(verdict(diagnosis(**there)))
    assert "othing is missing" not in text
    assert "No missing effect" not in text


def test_multiples_of_noise_are_reported_only_where_it_was_measured():
    guessed = diagnosis(finding(), budget=budget((0.0, 0.0, 0.31), noise=0.0), after=(1.9, 1.0, 1.05))
    page = summary(guessed)
    assert "x noise" not in page
    assert "noise" not in next(line for line in page.splitlines() if line.startswith("joint "))
    contained = 'Sensor noise was not measured at rest: it is part of "nothing that was recorded".'
    assert contained in " ".join(page.split())
    assert "x noise" in summary(diagnosis(finding()))
    assert "x noise" not in " ".join(verdict(replace(guessed, findings=(), budget=budget(noise=0.0))))


def test_the_verdict_comes_first_and_the_budget_adds_up_to_a_hundred():
    lines = summary(diagnosis(finding())).splitlines()
    start, end = lines.index("Residual by cause"), len(lines)
    assert lines.index("Verdict") < start
    shares = re.findall(r"(\d+) % \([\d.]+\)$", "\n".join(lines[start:end]), flags=re.M)
    assert sum(map(int, shares)) == 100
    assert (
        "- Joint 3: load-dependent friction explains 31 % of the squared residual (2.00 N m rms); of the "
        "rest, the largest part (43 %) depends on velocity."
    ) in " ".join(line.strip() for line in lines)
    table = plain(diagnosis(finding()))["budget"]
    np.testing.assert_allclose(sum(np.array(one["percent"]) for one in table["shares"]), 100.0)
    assert table["shares"][0]["finding"] == 0
    assert table["before_rms"] == [2.0] * 3


def test_whole_per_cents_add_up():
    shares = np.array([[1 / 3], [1 / 3], [1 / 3]])
    assert sorted(percents(shares)[:, 0]) == [33, 33, 34]
    assert list(percents(np.array([[0.004], [0.996]]))[:, 0]) == [0, 100]


def test_small_kinds_are_one_line():
    one = diagnosis(budget=budget(load=(0.004,) * 3, time=(0.002,) * 3, position=(0.0, 0.0, 0.2)))
    page = summary(one)
    assert "other kinds, less than 1 % each" in page
    assert "depends on load" not in page
    assert "depends on position" in page
    assert [part["kind"] for part in plain(one)["budget"]["shares"]].count("load") == 1


def test_what_has_no_certain_name_is_one_sentence_with_what_it_may_be():
    others = (other("time_delay", (), 0.2), other("backlash", (2,), 0.12))
    one = diagnosis(undecided=(finding("joint_spring", probability=0.65, alternatives=others),))
    assert verdict(one)[0] == (
        "Joint 3: the missing effect is joint spring (65 %), time delay of the arm (20 %) or backlash "
        "(12 %); what would settle it: slow sweeps over the whole range (exidyn excite --kind sweeps)."
    )
    assert "Joint spring of joint 3, undecided\n  probability 65 %" in summary(one)
    leaning = diagnosis(undecided=(finding("base_tilt", (), probability=0.95, alone=True),))
    assert (
        "The arm: the missing effect is base tilt (95 %), but only one joint shows it" in verdict(leaning)[0]
    )
    beside = diagnosis(undecided=(finding(probability=0.4, unnamed=True),))
    assert "or something that acts like it: the unexplained residual there is as large" in verdict(beside)[0]
    [table] = plain(one)["undecided"]
    assert (table["effect"], table["probability"], table["joints"]) == ("joint_spring", 0.65, [3])
    assert plain(one)["findings"] == []
    assert (
        "joint spring of joint 3 (name undecided)"
        in summary(replace(one, budget=budget((0.0, 0.0, 0.31)))).lower()
    )


def test_a_contact_of_a_run_held_out_is_reported():
    moment = Moment("other", 3.2, 3.6, (0, 2), np.array([0.0, -1.0, 0.0]), 31.4)
    one = diagnosis(moments=(moment,))
    assert verdict(one)[0] == (
        "other, 3.20 to 3.60 s: joints 1 and 3 differ from the model as at no other time, as if a force of "
        "31 N acted on the flange along (0.00, -1.00, 0.00) in the axes of the base."
    )
    assert "Moments: times at which a run differs from the model" in summary(one)
    assert plain(one)["moments"] == [
        {
            "run": "other",
            "start": 3.2,
            "end": 3.6,
            "joints": [1, 3],
            "direction": [0.0, -1.0, 0.0],
            "force": 31.4,
        }
    ]


def test_candidates_are_listed_with_what_each_alone_would_change():
    every = tuple(Change("backlash", (place % 3,), 1, -30.0 + place, 4.0, 9.0) for place in range(12))
    page = summary(diagnosis(changes=every))
    assert page.count("Backlash of joint") == 10
    assert re.search(r"Backlash of joint 1  Joint 2 +-30\.0     4\.0\n", page)
    assert "and 2 more" in page
    assert "exidyn identify" in page
    table = plain(diagnosis(changes=every))["changes"]
    assert len(table) == 12
    assert table[0] == {
        "effect": "backlash",
        "joints": [1],
        "joint": 2,
        "squared_error_percent": -30.0,
        "std_percent": 4.0,
        "gain": 9.0,
        "which": "",
    }


@pytest.mark.parametrize(
    ("effect", "parameters", "message"),
    [
        (
            "friction_asymmetry",
            {"Fa3": "N m", "Fva3": "N m s/rad"},
            "0.120 ± 0.012 N above the mean of both",
        ),
        ("friction_asymmetry", {"Fa3": "N m", "Fva3": "N m s/rad"}, "viscous friction 0.120 ± 0.012 N s/m"),
        ("viscous_friction", {"Fv3": "N m s/rad"}, "0.120 ± 0.012 N s/m higher"),
        ("joint_spring", {"Ks3": "N m/rad"}, ": 0.120 ± 0.012 N/m"),
        ("rotor_inertia", {"Ia3": "kg m^2"}, "0.120 ± 0.012 kg larger"),
        ("backlash", {"gap": "rad"}, ": 120 ± 12 mm"),
        ("load_dependent_friction", {"mu3": "1"}, "0.120 ± 0.012 N per N that"),
    ],
)
def test_joints_that_slide_have_units_of_their_own(effect, parameters, message):
    numbers = {name: Quantity(0.12, 0.006, unit) for name, unit in parameters.items()}
    one = finding(effect, parameters=numbers)
    page = " ".join(summary(sliding(diagnosis(one))).split())
    assert message in page
    assert "2.00 -> 1.00 N (10.0" in page
    assert "squared residual (2.00 N rms)" in page
    units = [
        quantity["unit"] for quantity in plain(sliding(diagnosis(one)))["findings"][0]["parameters"].values()
    ]
    assert not any("N m" in unit or "rad" in unit for unit in units)
    assert message not in " ".join(summary(diagnosis(one)).split())


def test_what_has_no_name_is_reported_with_where_it_shows():
    left = (Remainder(1, 2.14, 0.999, "position and velocity"),)
    text = verdict(diagnosis(remainders=left))[0]
    assert text == (
        "Something is missing, and it is none of the effects that exidyn knows: joint 2 keeps a residual "
        "of 1.00 N m (2.00 x its noise), and part of it depends on position and velocity."
    )
    assert verdict(diagnosis(finding(), remainders=left))[1].startswith("Something more is missing")


def test_alternatives_are_named_with_the_run_that_would_settle_it():
    others = (other("torque_ripple", (2,), 0.12), other("load_dependent_friction", (1,), 0.06))
    detail = verdict(diagnosis(finding(alternatives=others, probability=0.82)))[1]
    assert "probability 82 %" in detail
    assert (
        "Not excluded: torque ripple of joint 3 (12 %) and load-dependent friction of joint 2 (6 %)" in detail
    )
    assert "settle it: a run with a body of known mass on the flange (exidyn excite --mass)." in detail
    assert "torque ripple" not in detail.partition("Not excluded")[0]


def test_small_and_unconfirmed_findings_are_called_so():
    detail = verdict(diagnosis(finding(torque=0.02, held_out=-3.0)))[1]
    assert "It is small, 0.10 x noise" in detail
    assert "predicted no better with it" in detail
    assert "It is small" not in verdict(diagnosis(finding()))[1]


def test_warnings_come_last_as_sentences_and_what_is_left_before_them():
    text = verdict(diagnosis(finding(), after=(1.6, 1.0, 1.0), warnings=("no run carries a known payload",)))
    assert text[-1] == "No run carries a known payload."
    assert text[-2].startswith("More than noise is left on joint 1 (1.60 x noise)")


def test_the_page_of_text_has_findings_intervals_and_ratios():
    page = summary(diagnosis(finding()))
    heading = "Load-dependent friction of joint 3"
    lines = page.splitlines()
    sure = lines[lines.index(heading) + 1]
    assert sure == "  probability above 99.9 %, held-out score 900"
    assert lines[lines.index(heading) + 2].split() == ["mu3", "0.1200", "0.012"]
    joint = [line for line in lines[lines.index(heading) :] if line.startswith("Joint 3 ")][0]
    # noise, nominal values, before and after by the budget, and the two over noise
    assert joint.split()[4:] == ["0.2000", "0.5400", "2.000", "1.000", "10.00", "5.000"]
    assert max(map(len, lines)) <= 80
    assert "Held out:         none" in summary(diagnosis(finding(), **NO_HELD_OUT))


def test_answers_count_joints_from_one():
    others = (other("torque_ripple", (1,), 0.2),)
    found = answer(diagnosis(finding(alternatives=others), seconds=12.345))
    assert found == {
        "findings": [
            {
                "effect": "load_dependent_friction",
                "joints": [3],
                "confidence": 0.9995,
                "alternatives": [{"effect": "torque_ripple", "joints": [2]}],
                "parameters": {"mu3": [0.12, 0.006]},
            }
        ],
        "unexplained": False,
        "torque_rms_before": pytest.approx([1.1, 0.5, 0.54]),
        "torque_rms_after": pytest.approx([1.02, 0.5, 0.21]),
        "torque_rms_filter_hz": 25.0,
        "seconds": 12.35,
    }
    assert "torque_rms_before" not in answer(diagnosis(**NO_HELD_OUT))
    assert answer(diagnosis(remainders=(Remainder(0, 2.0, 1.0, "time"),)))["unexplained"]


def test_a_plain_diagnosis_is_json_without_nan():
    one = finding(parameters={"mu3": Quantity(0.12, np.nan, "1")}, held_out=np.nan)
    table = json.loads(
        json.dumps(plain(diagnosis(one, remainders=(Remainder(0, 2.0, 1.0, "time"),))), allow_nan=False)
    )
    assert table["findings"][0]["parameters"]["mu3"] == {"value": 0.12, "std": None, "unit": "1"}
    assert table["findings"][0]["held_out"] is None
    assert table["remainders"][0]["joint"] == 1
    assert table["verdict"][0].startswith("Joint 3 has load-dependent friction")


def moment(joints, force):
    return Moment("run_2", 1.0, 1.3, joints, np.full(3, np.nan) if np.isnan(force) else np.eye(3)[2], force)


def test_what_one_joint_alone_shows_is_no_force_on_the_flange():
    one, two = moment((1,), np.nan), moment((1, 2), 12.0)
    assert "force" not in moment_sentence(one)
    assert "as if a force of 12 N acted on the flange along (0.00, 0.00, 1.00)" in moment_sentence(two)
    assert direction(one) == "-"


def test_a_warning_that_begins_with_a_run_keeps_the_run_s_name():
    found = replace(diagnosis(finding()), runs=("run_1",), warnings=("run_1: 3 gaps", "no payload"))
    assert verdict(found)[-2:] == ["run_1: 3 gaps.", "No payload."]


def test_a_suspected_mistake_of_the_input_comes_before_all():
    suspected = (
        "log: the positions of joint1 and joint2 are exchanged (probability 76 %): give them the other way"
    )
    first, second, *_ = verdict(diagnosis(finding(), suspicions=(suspected,)))
    assert first.startswith("Check the input first: Log: the positions of joint1")
    assert first.endswith("What follows holds only if the input is right.")
    assert "friction" in second
