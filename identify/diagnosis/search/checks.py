"""Checks at the end of a search: findings beside all others, and what runs held out say of them."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from ..blocks.prediction import Prediction
from ..questions.block_answer import Answer
from ..questions.comparison import by_blocks, colouring, levelled
from ..questions.question import ask
from ..questions.shape import refined
from .problem import Problem
from .selected import Selected, answers_of, judged, keys_of

WORSE = 1.02
"""Residual of a joint held out, over that without any finding, which is no harm yet: noise does that [-]."""


def checked(
    problem: Problem, found: list[Selected], without_findings: Prediction, total: float
) -> list[Selected]:
    """Findings that stand beside all others, with their odds beside those that are left after every check."""
    for _ in found:
        found = _beside_all(problem, found, total)
        left = _never_worse(problem, found, without_findings, total)
        if keys_of(left) == keys_of(found):
            return left
        found = left
    return found


def _beside_all(problem: Problem, found: list[Selected], total: float) -> list[Selected]:
    """Findings each in its best shape, and compared anew with what else it may be, beside all others.

    One that is not credible beside them goes.
    """
    whole = problem.prediction(answers_of(found))
    for one in found:
        if one.once or not (one.others or one.answer.candidate.bounds):
            continue
        place, others = found.index(one), [other for other in found if other is not one]
        prediction = problem.prediction(answers_of(others), whole)
        first = _in_shape(problem, prediction, one.answer)
        again = _judged_as(prediction, one, first, others, total)
        found = [*found[:place], *([again] if again else []), *found[place + 1 :]]
    return found


def _judged_as(
    prediction: Prediction, one: Selected, shaped: Answer, others: Sequence[Selected], total: float
) -> Selected | None:
    """A finding in another shape compared anew with its alternatives, beside others; None if not credible."""
    keys = {other.answer.candidate.key for other in others}
    # What was excluded before others were found need not be beside them.
    rivals = [answer for answer, _ in one.others if answer.candidate.key not in keys]
    chosen = {rival.candidate.key: rival for rival in (shaped, *rivals)}
    asked = [(rival.candidate, rival.columns) for rival in (shaped, *rivals)]
    again = [answer.chosen_as(chosen[answer.candidate.key]) for answer in ask(prediction, asked)]
    again = sorted(levelled(prediction, again), key=lambda answer: -answer.gain)
    return judged(again, total, partial(by_blocks, prediction))


def _in_shape(problem: Problem, prediction: Prediction, answer: Answer) -> Answer:
    """The answer refined in shape beside everything else; it was chosen at the cost that it has."""
    if not answer.candidate.bounds:
        return answer
    again = ask(prediction, [(answer.candidate, answer.columns)])
    if not again:
        return answer
    shaped = refined(prediction, again[0].chosen_as(answer), problem.runs)
    return (again[0] if shaped.strange else shaped).chosen_as(answer)


def _never_worse(
    problem: Problem, found: list[Selected], without_findings: Prediction, total: float
) -> list[Selected]:
    """Findings with which no joint of the runs held out is predicted worse than without any.

    One goes if the joint that is predicted worst gains by that, and more than any other loses where it has a
    name; the least credible first. It stays in another shape if that predicts no joint worse. What none of
    them causes stays as it is.
    """
    while np.max(now := _held_out(problem, found, without_findings), initial=0.0) > WORSE**2:
        most, gone = 1.0, None
        for one in sorted((one for one in found if not one.once), key=lambda one: one.certainty):
            without = _held_out(problem, [other for other in found if other is not one], without_findings)
            gained = float(np.max(now) / np.max(without))
            lost = float(np.max(without / now)) if one.named else 1.0
            if gained > max(WORSE * most, lost):
                most, gone = gained, one
        if gone is None:
            break
        place, others = found.index(gone), [other for other in found if other is not gone]
        again = _in_other_shape(problem, others, gone, without_findings, total)
        found = [*others[:place], *again, *others[place:]]
    return found


def _in_other_shape(
    problem: Problem, others: list[Selected], one: Selected, without_findings: Prediction, total: float
) -> list[Selected]:
    """A finding in its most probable shape that predicts no joint of the runs held out worse, if any."""
    prediction = problem.prediction(answers_of(others))
    shapes = [pair for pair in problem.asked if pair[0].key == one.answer.candidate.key]
    for answer in sorted(ask(prediction, shapes), key=lambda answer: -answer.gain):
        shaped = colouring(prediction, answer).chosen_as(one.answer)
        again = _judged_as(prediction, one, shaped, others, total)
        if again is None or again.answer.candidate.key != one.answer.candidate.key:
            break
        if np.max(_held_out(problem, [*others, again], without_findings)) <= WORSE**2:
            return [again]
    return []


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
