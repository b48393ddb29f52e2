"""Runs held out: findings and fitted parameters predict them no worse than the nominal model does."""

from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis.questions.block_answer import CERTAIN_ODDS
from exidyn.identification.diagnosis.search import checks, held_out
from exidyn.identification.diagnosis.search.ranking import total_prior

from ...parts.small import two_joints
from ...parts.small.small_search import drag_search, names, record, searched, spring_search


def test_a_finding_is_compared_with_the_model_without_it_on_runs_held_out():
    found = spring_search()
    with_spring, without = (
        checks._held_out(found.problem, some, found.without_findings) for some in (found.selected, ())
    )
    assert with_spring[1] < 0.5
    assert np.all(without > 0.95)  # but for weights that are estimated anew


@pytest.mark.parametrize(
    ("fitted", "nominal", "kept"), [(1.2, 0.9, "nominal"), (1.2, 1.3, "fitted"), (1.03, 0.9, "fitted")]
)
def test_nominal_values_stay_where_fitted_ones_predict_a_joint_worse(monkeypatch, fitted, nominal, kept):
    at_nominal = SimpleNamespace()
    as_fitted = SimpleNamespace(at_nominal=lambda: at_nominal)
    squares = {id(as_fitted): [0.5, fitted], id(at_nominal): [0.5, nominal]}
    monkeypatch.setattr(checks, "_held_out", lambda one, *_: np.array(squares[id(one)]))
    chosen = checks.nominal_if_better(as_fitted, [object()], None)
    assert chosen is {"nominal": at_nominal, "fitted": as_fitted}[kept]
    assert checks.nominal_if_better(as_fitted, [], None) is as_fitted


def test_a_problem_at_nominal_holds_what_the_model_states():
    one = spring_search().problem
    held, free = one.at_nominal().prediction([]), one.prediction([])
    np.testing.assert_allclose(held.values[one.stated], held.rows.mean[one.stated], atol=1e-9)
    assert np.any(np.abs(free.values - free.rows.mean)[one.stated] > 1e-3)


def test_a_finding_that_predicts_a_joint_held_out_worse_goes(monkeypatch):
    found = spring_search()
    [spring], total = found.selected, total_prior(found.problem)

    def judged(with_it, without):
        ratios = {True: np.array(with_it), False: np.array(without)}
        monkeypatch.setattr(checks, "_held_out", lambda _, some, __: ratios[bool(some)])
        return checks.checked_by_held_out(found.problem, [spring], found.without_findings, total)

    assert judged([0.5, 0.5], [1.0, 1.0]) == [spring]
    assert judged([1.0, 1.5], [1.0, 1.0]) == []
    assert judged([0.2, 1.1], [1.0, 1.05]) == []  # no joint may become worse
    assert judged([0.2, 1.06], [1.0, 1.05]) == [spring]  # by more than noise
    assert judged([1.0, 1.5], [1.0, 1.5]) == [spring]  # it is not what makes it worse


def test_a_finding_that_runs_held_out_contradict_goes():
    def elsewhere(role, motion, current):
        """A spring in the runs fitted, and its opposite in the one held out."""
        sign = 1.0 if role == "identify" else -1.0
        return current + sign * np.outer(6.0 * motion.position[:, 1], [0.0, 1.0]) / two_joints.GAIN

    assert names(searched(record(change=elsewhere))) == []


def test_a_finding_that_predicts_a_joint_worse_in_one_shape_stays_in_another(monkeypatch):
    found = drag_search()
    [drag] = found.selected
    best = drag.answer.candidate

    def held_out(problem, some, without_findings):
        return np.array([1.0, 1.5 if any(one.answer.candidate is best for one in some) else 1.0])

    monkeypatch.setattr(checks, "_held_out", held_out)
    [kept] = checks.checked_by_held_out(
        found.problem, [drag], found.without_findings, total_prior(found.problem)
    )
    assert kept.answer.candidate.key == best.key
    assert kept.answer.candidate.shape != best.shape
    assert CERTAIN_ODDS < kept.odds < drag.odds


def test_findings_that_share_the_blame_go_until_no_joint_is_worse(monkeypatch):
    found = spring_search()
    [spring] = found.selected
    three = [spring._replace(odds=spring.odds - k) for k in range(3)]
    ratios = {0: 1.0, 1: 1.01, 2: 1.06, 3: 1.1}  # each is harmless alone
    monkeypatch.setattr(checks, "_held_out", lambda _, some, __: np.array([0.5, ratios[len(some)] ** 2]))
    monkeypatch.setattr(checks, "_in_another_shape", lambda *_: None)
    [kept] = checks.without_harmful(found.problem, three, found.without_findings, 1.0)
    assert kept is three[0]  # the most certain comes back


@pytest.mark.parametrize(
    ("before", "after", "less"),
    [
        ([450.0, 50.0, 80.0], [0.5, 0.4, 0.6], True),
        ([4.0, 5.0, 6.0, 4.0], [3.9, 5.2, 5.7, 4.1], False),
        ([4.0, 5.0], [8.0, 9.0], True),  # too few to say
    ],
)
def test_what_is_explained_excludes_zero_by_the_scatter_of_blocks(before, after, less):
    assert held_out.explains(np.array(before), np.array(after)) == less
