"""What a search takes for found, for the same thing twice, and for confirmed."""

from types import SimpleNamespace

import numpy as np
import pytest
from exidyn.identify.diagnosis.candidate import Candidate, Thinned
from exidyn.identify.diagnosis.confirmed import _stands
from exidyn.identify.diagnosis.formulas import told_apart
from exidyn.identify.diagnosis.found import CREDIBLE, Found, competing, judged
from exidyn.identify.diagnosis.hypothesis import Hypothesis, strange
from exidyn.identify.diagnosis.remainder import excess
from exidyn.identify.diagnosis.solution import CERTAIN, Share, marginal

COUNT = 150


def hypothesis(effect, joints, evidence, rows=None, mean=0.0, value=1.0):
    candidate = Candidate(effect, joints, lambda run: run, ("size",), ("N m",), (-np.inf,))
    acting = np.array(joints if rows is None else rows)
    columns = Thinned(acting, np.ones((4, len(acting), 1)), np.array([0.1]), np.array([mean]))
    return Hypothesis(candidate, columns, np.array([value]), evidence, evidence)


def found(effect, joints, evidence, **more):
    return Found(hypothesis(effect, joints, evidence, **more), (), evidence)


def names(every):
    return [(one.hypothesis.candidate.effect, one.hypothesis.candidate.joints) for one in every]


def test_nothing_is_found_that_is_one_of_many_hypotheses_by_chance():
    assert judged([], COUNT) is None
    assert judged([hypothesis("backlash", (1,), 6.0)], COUNT) is None
    sure = judged([hypothesis("backlash", (1,), 30.0)], COUNT)
    assert sure is not None
    assert sure.probability > CREDIBLE


def test_alternatives_are_what_explains_the_same_joint():
    rivals = [hypothesis("stribeck_friction", (2,), 29.0), hypothesis("viscous_friction", (4,), 29.5)]
    one = judged([hypothesis("hysteresis", (2,), 30.0), *rivals], COUNT)
    assert one is not None
    assert [other.candidate.effect for other, _ in one.not_excluded] == ["stribeck_friction"]
    assert one.probability == pytest.approx(1 / (1 + np.exp(-1.0)), abs=1e-6)


def test_an_alternative_that_is_credible_beside_a_finding_is_the_next_finding():
    rival = hypothesis("stribeck_friction", (2,), 29.0)
    one = judged([hypothesis("joint_spring", (2,), 30.0), rival], COUNT)
    assert one is not None
    assert one.not_excluded
    assert not one.beside([hypothesis("stribeck_friction", (2,), 28.0)], COUNT).not_excluded
    assert one.beside([hypothesis("stribeck_friction", (2,), 0.0)], COUNT).not_excluded


def test_small_friction_beside_a_great_one_is_its_formulas_error():
    great, small = found("stribeck_friction", (3,), 400.0), found("nonlinear_viscous_friction", (3,), 15.0)
    assert names(told_apart([small, great])) == [("stribeck_friction", (3,))]
    elsewhere = found("nonlinear_viscous_friction", (2,), 15.0)
    assert len(told_apart([elsewhere, great])) == 2
    comparable = found("nonlinear_viscous_friction", (3,), 90.0)
    assert len(told_apart([comparable, great])) == 2
    another_kind = found("spring_balancer", (3,), 15.0)
    assert len(told_apart([another_kind, great])) == 2


def test_what_a_floating_link_shakes_elsewhere_is_no_finding():
    play = found("backlash", (0,), 9000.0, rows=(0, 1, 2))
    assert names(told_apart([play, found("time_delay", (2,), 60.0)])) == [("backlash", (0,))]
    assert len(told_apart([play, found("time_delay", (2,), 200.0)])) == 2


def test_competing_is_a_matter_of_joints():
    assert competing(hypothesis("a", (), 1.0, rows=(0, 1, 2)), hypothesis("b", (2,), 1.0))
    assert not competing(hypothesis("a", (1,), 1.0), hypothesis("b", (2,), 1.0))


@pytest.mark.parametrize(
    ("evidence", "gain", "stands"),
    [
        (12.0, -6.0, True),  # so little may be lost by chance
        (12.0, -25.0, False),
        (100.0, -6.0, False),  # so much should have been gained
        (100.0, 3.0, True),
        (12.0, np.nan, True),  # nothing held out
    ],
)
def test_runs_held_out_may_speak_against_a_finding(evidence, gain, stands):
    one = Found(hypothesis("drive_gain", (1,), evidence), (), evidence - np.log(COUNT))
    assert bool(_stands(one, gain, expected=2.0 * evidence * 0.33)) == stands


def test_coefficient_far_from_what_physics_says_is_another_effects():
    clip = hypothesis("current_clipping", (1,), 50.0, mean=1.0)
    assert not strange(clip.columns, np.array([1.2]))
    assert strange(clip.columns, np.array([0.45]))


def test_marginal_probability_is_that_of_a_normal_distribution():
    rng = np.random.default_rng(2)
    columns, std, scale = rng.normal(size=(40, 3)), np.array([0.5, 1.0, 2.0]), 0.3
    rows = rng.normal(size=40)
    acting = np.arange(3)
    share = Share.of(columns / scale, rows / scale, 40 * np.log(scale), acting, 3)
    _, probability = marginal([share], 1 / std**2, np.zeros(3))
    covariance = scale**2 * np.eye(40) + (columns * std**2) @ columns.T
    exact = -0.5 * rows @ np.linalg.solve(covariance, rows) - 0.5 * np.linalg.slogdet(covariance)[1]
    assert probability == pytest.approx(exact, rel=1e-8)


def test_a_detail_at_its_limit_stays_there_and_the_effect_remains():
    candidate = Candidate("backlash", (0,), lambda run: run, ("share", "compliance"), ("1", "1"), (0.0, 0.0))
    columns = Thinned(np.array([0]), np.ones((4, 1, 2)), np.array([0.15, 1e-5]), np.array([1.0, 0.0]))
    one = Hypothesis(candidate, columns, np.array([0.98, 0.0]), 4000.0, 4000.0)
    share, compliance = one.found_std
    assert share > 0.9
    assert compliance == CERTAIN


@pytest.mark.parametrize(("over", "left"), [(1.5, 0.0), (3.0, 8.0)])
def test_power_is_in_excess_only_where_drives_that_move_are_not_as_noisy(over, left):
    rows = SimpleNamespace(weight=np.ones((100, 1)))
    solution = SimpleNamespace(residual=np.full((100, 1), over * 0.2), rows=rows)
    assert excess(solution, 0, 0.2) == pytest.approx(left * 0.2**2)


def test_a_joint_has_one_spring_and_a_drive_one_end():
    spring = found("joint_spring", (3,), 260.0)
    assert names(told_apart([spring, found("spring_balancer", (3,), 54.0)])) == [("joint_spring", (3,))]
    assert len(told_apart([spring, found("spring_balancer", (2,), 54.0)])) == 2
    end = found("drive_gain_saturation", (3,), 780.0)
    trace = found("position_dependent_friction", (3,), 18.0)
    assert names(told_apart([end, trace])) == [("drive_gain_saturation", (3,))]
    sag = found("supply_sag", (), 280.0, rows=(0, 1, 2, 3))
    assert names(told_apart([sag, found("drive_gain_saturation", (3,), 14.0)])) == [("supply_sag", ())]
