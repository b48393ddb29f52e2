"""Checks at the end of a search: what runs held out say of findings, and of the fitted parameters."""

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
"""Residual of a joint held out, over that without any finding, which is no harm yet: noise does that [-]."""


def again_beside(
    problem: Problem, answer: Answer, others: Sequence[Answer], near: Prediction
) -> Answer | None:
    """The answer of the same candidate beside some others; None where physics excludes it there."""
    prediction = problem.prediction(others, near)
    again = ask(prediction, [(answer.candidate, answer.columns)])
    return colouring(prediction, again[0]).chosen_as(answer) if again else None


def in_shape(problem: Problem, prediction: Prediction, answer: Answer) -> Answer:
    """The answer refined in shape beside everything else; it was chosen at the cost that it has."""
    if not answer.candidate.bounds:
        return answer
    again = ask(prediction, [(answer.candidate, answer.columns)])
    if not again:
        return answer
    shaped = refined(prediction, again[0].chosen_as(answer), problem.runs)
    return (again[0] if shaped.strange else shaped).chosen_as(answer)


def judged_by_held_out(
    problem: Problem, selected: list[Selected], without_findings: Prediction, total: float
) -> list[Selected]:
    """Findings that runs held out do not contradict; no other name is chosen in place of one that goes.

    A finding goes that makes those runs less probable beside all others, or a joint of them worse.
    """
    whole = problem.prediction(answers_of(selected))
    for one in sorted((one for one in selected if one.predicts_held_out), key=lambda one: one.certainty):
        others = [other for other in selected if other is not one]
        again = again_beside(problem, one.answer, answers_of(others), whole)
        if again and contradicted(again):
            selected = others
    return no_joint_worse(problem, selected, without_findings, total)


def no_joint_worse(
    problem: Problem, selected: list[Selected], without_findings: Prediction, total: float
) -> list[Selected]:
    """Findings with which no joint held out is predicted worse than without any, as many as there can be.

    Several may share the blame, so that none alone is guilty: that goes without which the worst joint is
    predicted best, until none is worse. Then each that went comes back if it does no harm beside the others,
    the most certain first, in its shape or in another one.
    """
    allowed = WORSE**2 * np.maximum(_held_out(problem, [], without_findings), 1.0)

    def worst(some: Sequence[Selected]) -> float:
        return float(np.max(_held_out(problem, some, without_findings) / allowed, initial=0.0))

    gone = list[Selected]()
    while worst(selected) > 1.0 and (removable := [one for one in selected if one.predicts_held_out]):
        without = {id(one): worst([other for other in selected if other is not one]) for one in removable}
        out = min(removable, key=lambda one: (without[id(one)], one.odds))
        selected = [one for one in selected if one is not out]
        gone.append(out)
    for one in sorted(gone, key=lambda one: -one.odds):
        if worst([*selected, one]) <= 1.0:
            selected = [*selected, one]
        elif shaped := _in_another_shape(problem, selected, one, worst, total):
            selected = [*selected, shaped]
    return selected


def _in_another_shape(
    problem: Problem,
    others: Sequence[Selected],
    gone: Selected,
    worst: Callable[[Sequence[Selected]], float],
    total: float,
) -> Selected | None:
    """A finding in its most probable shape that predicts no joint held out worse; None without any."""
    prediction = problem.prediction(answers_of(others))
    shapes = problem.pairs(lambda candidate, _: candidate.key == gone.answer.candidate.key)
    for answer in sorted(ask(prediction, shapes), key=lambda one: -one.gain):
        again = colouring(prediction, answer).chosen_as(gone.answer)
        shaped = gone._replace(answer=again, odds=again.odds + log_prior(again, total))
        if shaped.odds < CERTAIN_ODDS:
            break
        if worst([*others, shaped]) <= 1.0:
            return shaped
    return None


def nominal_where_better(
    problem: Problem, found: Sequence[Selected], without_findings: Prediction
) -> Problem:
    """The problem at nominal parameters, where those fitted predict a joint held out worse."""
    worst = np.max(_held_out(problem, found, without_findings), initial=0.0) if found else 0.0
    if worst <= WORSE**2:
        return problem
    nominal = problem.at_nominal()
    return nominal if np.max(_held_out(nominal, found, without_findings)) < worst else problem


def _held_out(problem: Problem, found: Sequence[Selected], without_findings: Prediction) -> np.ndarray:
    """Squared residuals of runs held out with findings, over those without any, shape (n,); else empty."""
    which = ~problem.blocks.fitted
    if not np.any(which):
        return np.zeros(0)
    nominal = without_findings.sums.errors(
        np.tile(problem.nominal_unknowns(without_findings), (len(which), 1))
    )
    least = np.minimum(
        without_findings.power(without_findings.errors, which), without_findings.power(nominal, which)
    )
    now = problem.prediction(answers_of(found))
    return now.power(now.errors, which) / least
