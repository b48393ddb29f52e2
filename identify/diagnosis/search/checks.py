"""Checks at the end of a search: what runs held out say of findings, and of the fitted parameters."""

from collections.abc import Sequence

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

    A finding goes that makes those runs less probable beside all others. So does one without which the joint
    that is predicted worst gains more than any other loses, unless another shape of it does no harm.
    """
    whole = problem.prediction(answers_of(selected))
    for one in sorted((one for one in selected if one.predicts_held_out), key=lambda one: one.certainty):
        others = [other for other in selected if other is not one]
        again = again_beside(problem, one.answer, answers_of(others), whole)
        if again and contradicted(again):
            selected = others
    reshaped = list[Selected]()
    while np.max(now := _held_out(problem, selected, without_findings), initial=0.0) > WORSE**2:
        gone = _makes_worse(problem, selected, now, without_findings)
        if gone is None:
            break
        others = [other for other in selected if other is not gone]
        shaped = (
            None if gone in reshaped else _in_another_shape(problem, others, gone, without_findings, total)
        )
        reshaped += [shaped] if shaped else []
        selected = [*others, *([shaped] if shaped else [])]
    return selected


def _in_another_shape(
    problem: Problem, others: list[Selected], gone: Selected, without_findings: Prediction, total: float
) -> Selected | None:
    """A finding in its most probable shape that predicts runs held out no worse than they are without it."""
    prediction = problem.prediction(answers_of(others))
    shapes = [pair for pair in problem.asked if pair[0].key == gone.answer.candidate.key]
    least = max(float(np.max(_held_out(problem, others, without_findings))), WORSE**2)
    for answer in sorted(ask(prediction, shapes), key=lambda one: -one.gain):
        again = colouring(prediction, answer).chosen_as(gone.answer)
        shaped = gone._replace(answer=again, odds=again.odds + log_prior(again, total))
        if shaped.odds < CERTAIN_ODDS:
            break
        if np.max(_held_out(problem, [*others, shaped], without_findings)) <= least:
            return shaped
    return None


def _makes_worse(
    problem: Problem, selected: Sequence[Selected], now: np.ndarray, without_findings: Prediction
) -> Selected | None:
    """The finding without which the worst predicted joint gains most, and more than any other loses."""
    most, gone = 1.0, None
    for one in (one for one in selected if one.predicts_held_out):
        without = _held_out(problem, [other for other in selected if other is not one], without_findings)
        gained, lost = float(np.max(now) / np.max(without)), float(np.max(without / now))
        if gained > max(WORSE * most, lost):
            most, gone = gained, one
    return gone


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
