"""Runs held out: findings predict them no worse than the model without findings does."""

import numpy as np
import pytest

from exidyn.identification.diagnosis.questions.block_answer import CERTAIN_ODDS
from exidyn.identification.diagnosis.search import checks, held_out
from exidyn.identification.diagnosis.search.ranking import total_prior

from ...parts.small import two_joints
from ...parts.small.small_search import drag_search, names, record, searched, spring_search


def test_a_finding_is_compared_with_the_model_without_it_on_runs_held_out():
    found = spring_search()
    assert checks._held_out(found.problem, found.selected, found.without_findings)[1] < 0.5


def test_a_finding_that_predicts_a_joint_held_out_worse_goes(monkeypatch):
    found = spring_search()
    [spring], total = found.selected, total_prior(found.problem)

    def judged(*ratios):
        monkeypatch.setattr(checks, "_held_out", lambda _, some, __: np.array(ratios if some else [1.0, 1.0]))
        return checks.checked_by_held_out(found.problem, [spring], found.without_findings, total)

    assert judged(0.5, 0.5) == [spring]
    assert judged(1.0, 1.5) == []
    assert judged(0.2, 1.05) == []  # no joint may become worse
    assert judged(0.2, 1.03) == [spring]  # by more than noise


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
