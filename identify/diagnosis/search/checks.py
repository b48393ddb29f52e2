"""Checks of a search: whether held-out runs contradict the findings and the fitted parameters."""

from collections.abc import Callable, Sequence

import numpy as np

from ..blocks.prediction import Prediction
from ..questions.block_answer import CERTAIN_ODDS, Answer
from ..questions.comparison import colouring
from ..questions.question import ask
from ..questions.shape import refined
from .problem import Problem
from .selected import Selected, answers_of, contradicted, log_prior

WORSE = 1.02
"""Largest held-out residual of a joint, relative to the baseline, that still counts as noise [-]."""


def answer_beside(
    problem: Problem, answer: Answer, others: Sequence[Answer], similar: Prediction
) -> Answer | None:
    """Answer of the same candidate with other findings in the model; None where physics excludes it."""
    prediction = problem.prediction(others, similar)
    answers = ask(prediction, [(answer.candidate, answer.columns)])
    return colouring(prediction, answers[0]).chosen_as(answer) if answers else None


def with_refined_shape(problem: Problem, prediction: Prediction, answer: Answer) -> Answer:
    """Answer with its shape refined given all other findings, at the cost of its original choice."""
    if not answer.candidate.bounds:
        return answer
    answers = ask(prediction, [(answer.candidate, answer.columns)])
    if not answers:
        return answer
    refined_answer = refined(prediction, answers[0].chosen_as(answer), problem.runs)
    return (answers[0] if refined_answer.strange else refined_answer).chosen_as(answer)


def checked_by_held_out(
    problem: Problem, selected: list[Selected], without_findings: Prediction, total: float
) -> list[Selected]:
    """Findings whose torque held-out runs do not contradict.

    A finding is left out if it makes the held-out runs less probable given all others, or predicts one of
    their joints worse. One that rests on priors, such as a drive gain, is judged by the joints alone: without
    it, other parameters give the same torque.
    """
    with_all = problem.prediction(answers_of(selected))
    judged = [finding for finding in selected if finding.predicts_held_out and not finding.by_priors]
    for finding in sorted(judged, key=lambda finding: finding.certainty):
        others = [other for other in selected if other is not finding]
        answer = answer_beside(problem, finding.answer, answers_of(others), with_all)
        if answer and contradicted(answer):
            selected = others
    return without_harmful(problem, selected, without_findings, total)


def without_harmful(
    problem: Problem, selected: list[Selected], without_findings: Prediction, total: float
) -> list[Selected]:
    """The most findings with which no held-out joint is predicted worse than by the baseline.

    Several findings may make a joint worse together, so they are removed one at a time: each time the one
    whose removal improves the worst joint most, until no joint is worse. Then each removed finding, the most
    certain first, is restored if it does no harm given the others, in its own shape or in another one.
    """

    def worst(findings: Sequence[Selected]) -> float:
        return float(np.max(_held_out(problem, findings, without_findings), initial=0.0)) / WORSE**2

    removed = list[Selected]()
    while worst(selected) > 1.0 and (
        removable := [finding for finding in selected if finding.predicts_held_out]
    ):
        without = {
            id(finding): worst([other for other in selected if other is not finding]) for finding in removable
        }
        harmful = min(removable, key=lambda finding: (without[id(finding)], finding.odds))
        selected = [finding for finding in selected if finding is not harmful]
        removed.append(harmful)
    for finding in sorted(removed, key=lambda finding: -finding.odds):
        if worst([*selected, finding]) <= 1.0:
            selected = [*selected, finding]
        elif reshaped := _in_another_shape(problem, selected, finding, worst, total):
            selected = [*selected, reshaped]
    return selected


def harmful(problem: Problem, findings: Sequence[Selected], without_findings: Prediction) -> bool:
    """Whether a held-out joint is predicted worse with these findings than by the baseline."""
    return bool(np.any(_held_out(problem, findings, without_findings) > WORSE**2))


def _in_another_shape(
    problem: Problem,
    others: Sequence[Selected],
    removed: Selected,
    worst: Callable[[Sequence[Selected]], float],
    total: float,
) -> Selected | None:
    """The finding in its most probable shape that predicts no held-out joint worse; None if there is none."""
    prediction = problem.prediction(answers_of(others))
    shapes = problem.pairs(lambda candidate, _: candidate.key == removed.answer.candidate.key)
    for shape in sorted(ask(prediction, shapes), key=lambda answer: -answer.gain):
        answer = colouring(prediction, shape).chosen_as(removed.answer)
        reshaped = removed._replace(answer=answer, odds=answer.odds + log_prior(answer, total))
        if reshaped.odds < CERTAIN_ODDS:
            break
        if worst([*others, reshaped]) <= 1.0:
            return reshaped
    return None


def _held_out(problem: Problem, findings: Sequence[Selected], without_findings: Prediction) -> np.ndarray:
    """Squared held-out residual of each joint relative to the baseline, (n,); empty without held-out runs."""
    if np.all(held_in := problem.blocks.fitted):
        return np.zeros(0)
    after, before = (
        prediction.power(prediction.errors, ~held_in)
        for prediction in (problem.prediction(answers_of(findings)), without_findings)
    )
    return after / before
