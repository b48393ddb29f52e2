"""What is learned from seasons of weekly runs of simulated arms."""

import numpy as np
import pytest

from exidyn.identification.fleet.compared import compared
from exidyn.identification.fleet.evidence import CREEP, STEP
from exidyn.identification.fleet.learned import SECONDS_A_YEAR, Expected, learned, scattered
from exidyn.identification.fleet.report import KindReport, amount_words, change_words
from exidyn.identification.fleet.runs import Frame

from ...parts.small.fleet_runs import SCATTER, START, kind_and_equations, season

BEGIN = 12
"""Week in which wear begins."""


def friction_step(weeks, values, gain):
    values["Fc2"] *= 1.1 if weeks >= BEGIN else 1.0


def friction_creep(weeks, values, gain):
    values["Fv1"] *= 1.0 + 0.1 * max(weeks - BEGIN, 0.0) / 8.0


def new_drive(weeks, values, gain):
    gain[1] *= 1.02 if weeks >= BEGIN else 1.0


@pytest.fixture(scope="module")
def report():
    arms = {
        "step": season(1, friction_step),
        "creep": season(2, friction_creep),
        "drive": season(3, new_drive),
    }
    arms |= {f"sound {k}": season(10 + k) for k in range(5)}
    frame = Frame.of(kind_and_equations()[0], [run for runs in arms.values() for run in runs])
    return KindReport.of("two", learned(frame, arms), 1.0)


@pytest.mark.parametrize(
    ("arm", "effect", "joint", "shape", "share"),
    [
        ("step", "coulomb_friction", 1, STEP, 0.1),
        ("creep", "viscous_friction", 0, CREEP, 0.1 * 13 / 8),
        ("drive", "drive_gain", 1, STEP, 0.02),
    ],
)
def test_a_change_is_named_dated_and_measured(report, arm, effect, joint, shape, share):
    found = max(report.drifts[arm].changes, key=lambda one: one.evidence)
    assert found.suspect.name == ""
    cause = report.learned.frame.causes[found.suspect.causes[0]]
    assert (cause.effect, cause.joint, found.shape) == (effect, joint, shape)
    assert found.amounts[0] / abs(found.usual[0]) == pytest.approx(share, rel=0.2)
    assert found.interval[0] <= START + 7.0 * BEGIN <= found.interval[1]
    assert found.alarmed <= START + 7.0 * (BEGIN + 4)
    assert "2026" in change_words(report.learned, found)


def test_sound_arms_raise_no_more_alarms_than_allowed(report):
    alarms = sum(len(report.drifts[f"sound {k}"].alarms) for k in range(5))
    assert alarms <= 2  # 2.5 arm-years at one a year would be 2.5; Bonferroni's bound is not reached


def test_scatter_from_run_to_run_is_found(report):
    places = [
        k for k, one in enumerate(report.wearing) if one.effect in ("viscous_friction", "coulomb_friction")
    ]
    found = np.sqrt(report.learned.scatter[places])
    assert np.all(found < 2.0 * SCATTER)
    assert np.median(found) > 0.5 * SCATTER


def test_values_at_the_reference_temperature_do_not_follow_the_season(report):
    values, stds = report.values("sound 0")
    place = [one.parameter for one in report.wearing].index("Fv1")
    assert np.std(values[:, place]) < 0.02 * np.mean(values[:, place])  # 20 K change it by 50 %
    assert np.all(stds[:, place] > 0.0)


def test_an_arm_does_not_differ_from_itself_and_units_do(report):
    learned_, arms = report.learned, report.learned.arms
    sound = arms["sound 1"]
    assert compared(learned_, sound[3:4], sound[20:21]) == []
    between = {one.parameter for one in compared(learned_, arms["sound 1"], arms["sound 2"])}
    assert between & {"Fv1", "Fv2", "Fc1", "Fc2"}


def test_an_alarm_allowed_seldom_needs_more_evidence(report):
    runs = report.learned.arms["step"]
    seldom = KindReport.of("two", report.learned, 0.01).drifts["step"]
    assert seldom.price > report.drifts["step"].price
    assert len(runs.runs) == 26


def test_residuals_of_sound_runs_exceed_their_limit_as_seldom_as_is_allowed(report):
    share, over, asked = 0.02, 0, 0
    for k in range(5):
        runs = report.learned.arms[f"sound {k}"]
        for left_out in range(0, 26, 4):
            others = Expected.of(report.learned, runs[np.delete(np.arange(26), left_out)])
            limit = others.limit(share * SECONDS_A_YEAR * 2 / others.seconds)
            over += np.sum(others.residual(runs.runs[left_out]) > limit)
            asked += 2
    assert over <= 5  # of a share of 0.02 a binomial number is more in one of 300
    assert asked == 70


def other_drives(weeks, values, gain):
    gain *= [1.06, 0.95]


def test_a_body_that_nobody_knows_is_no_change_of_the_arm():
    carried = range(2, 26, 5)
    arms = {f"{k}": season(30 + k, other_drives, bodies=carried if k < 2 else ()) for k in range(4)}
    frame = Frame.of(kind_and_equations()[0], [run for runs in arms.values() for run in runs])
    found = KindReport.of("two", learned(frame, arms), 1.0)
    for arm in ("0", "1"):
        assert found.drifts[arm].alarms == ()
        values, stds = found.values(arm)
        usual = np.mean(np.delete(values, carried, axis=0), axis=0)
        assert np.all(np.abs(values[carried] - usual) < 5.0 * np.hypot(stds[carried], SCATTER * usual))


@pytest.mark.parametrize("count", [1, 2, 3])
def test_of_a_few_runs_nothing_is_asked(count):
    runs = {"new": season(20, weeks=count)}
    frame = Frame.of(kind_and_equations()[0], runs["new"])
    own = KindReport.of("two", learned(frame, runs), 1.0).drifts["new"]
    assert own.changes == own.alarms == ()


def test_few_runs_are_too_few_for_a_change():
    arms = {f"new {k}": season(20 + k)[:3] for k in range(3)}
    frame = Frame.of(kind_and_equations()[0], [run for runs in arms.values() for run in runs])
    found = KindReport.of("two", learned(frame, arms), 1.0)
    assert [drift.changes for drift in found.drifts.values()] == [(), (), ()]


def test_a_change_is_written_with_half_of_its_interval_and_without_an_exponent():
    assert amount_words(-96.0, 17.0, 100.0, "N m") == "down 96 ± 33 %"
    assert amount_words(0.00171, 0.00041, np.nan, "kg m") == "up 0.00171 ± 0.00080 kg m"
    assert amount_words(253.0, 20.0, 100.0, "N m") == "up 253 ± 39 %"


def test_scattered_runs_say_what_inverting_their_covariance_says():
    random = np.random.default_rng(0)
    root = random.normal(size=(1, 8, 4))
    normal, right = np.swapaxes(root, 1, 2) @ root, random.normal(size=(1, 4))
    directions, variance = random.normal(size=(2, 4)), np.array([0.3, 2.0])
    found, side = scattered(normal, right, directions, variance)
    covariance = np.linalg.inv(normal[0]) + directions.T @ np.diag(variance) @ directions
    np.testing.assert_allclose(found[0], np.linalg.inv(covariance), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(
        side[0], np.linalg.inv(covariance) @ np.linalg.solve(normal[0], right[0]), rtol=1e-8
    )
