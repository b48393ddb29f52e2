"""Checks at the end of a search: what runs held out say of findings, and of the fitted parameters."""

from collections.abc import Sequence

import numpy as np

from ..blocks.prediction import Prediction
from ..questions.block_answer import Answer
from ..questions.comparison import colouring
from ..questions.question import ask
from ..questions.shape import refined
from .problem import Problem
from .selected import Selected, answers_of, contradicted

WORSE = 1.02
"""Residual of a joint held out, over that without any finding, which is no harm yet: noise does that [-]."""


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
    problem: Problem, selected: list[Selected], without_findings: Prediction
) -> list[Selected]:
    """Findings that runs held out do not contradict; nothing else is chosen in place of one that goes.

    One goes that makes them less probable beside all others, or with which the joint that is predicted worst
    gains by its absence more than any other loses.
    """
    whole = problem.prediction(answers_of(selected))
    for one in sorted((one for one in selected if not one.once), key=lambda one: one.certainty):
        others = [other for other in selected if other is not one]
        prediction = problem.prediction(answers_of(others), whole)
        again = ask(prediction, [(one.answer.candidate, one.answer.columns)])
        if again and contradicted(colouring(prediction, again[0])):
            selected = others
    while np.max(now := _held_out(problem, selected, without_findings), initial=0.0) > WORSE**2:
        gone = _makes_worse(problem, selected, now, without_findings)
        if gone is None:
            break
        selected = [other for other in selected if other is not gone]
    return selected


def _makes_worse(
    problem: Problem, selected: Sequence[Selected], now: np.ndarray, without_findings: Prediction
) -> Selected | None:
    """The finding without which the worst predicted joint gains most, and more than any other loses."""
    most, gone = 1.0, None
    for one in (one for one in selected if not one.once):
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
    word = without_findings.sums.errors(np.tile(problem.nominal_unknowns(without_findings), (len(which), 1)))
    least = np.minimum(
        without_findings.power(without_findings.errors, which), without_findings.power(word, which)
    )
    now = problem.prediction(answers_of(found))
    return now.power(now.errors, which) / least
