"""Search: one effect at a time is added, everything solved anew, until nothing more is credible."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..blocks.prediction import Prediction
from ..candidates import kinds
from ..questions.block_answer import Answer
from ..questions.candidate import Thinned
from ..questions.candidate_fit import FORMULA
from ..questions.comparison import by_blocks, colouring, levelled
from ..questions.question import ask
from ..questions.shape import refined
from .link_encoders import measured_gears
from .mounting import mounted_otherwise
from .once import only_once
from .problem import Problem
from .selected import CERTAIN_ODDS, Selected, judged, log_prior

TURNS = 16
"""Times that something is added, at most: what came in may go out again for something better."""
COLOURED = 14
"""Hypotheses whose answers are weighed with the colour of what they leave."""
REFINE = 3
"""Hypotheses whose shape is refined before the best is chosen."""
MATERIAL = FORMULA**2
"""Share of what the nominal model misses on a joint that an effect explains there at least [-]: as much as
the formula of the greatest effect may leave."""
WORSE = 1.02
"""Residual of a joint held out, over that without any finding, which is no harm yet: noise does that [-]."""
NEAR = 0.5
"""Share of the foremost gain below which no finer shape makes a hypothesis the foremost [-]."""


@dataclass(frozen=True, eq=False)
class SearchResult:
    """What a search has come to.

    Attributes:
        problem: The runs, and what was asked.
        selected: In the order of their columns, the greatest first.
        prediction: With columns for everything that was found, at the end of its rows.
        without_findings: Prediction without any of them.
        single: Answers of all hypotheses, each beside nothing else, the most probable first.
        left: Answers of those that were not taken, each beside all that was, the most probable first.
        total: Sum of the prior weights of all hypotheses.
    """

    problem: Problem
    selected: tuple[Selected, ...]
    prediction: Prediction
    without_findings: Prediction
    single: tuple[Answer, ...]
    left: tuple[Answer, ...] = ()
    total: float = 1.0

    def ordered(self) -> "SearchResult":
        """The same with those findings first that are certain enough to be named."""
        selected = sorted(self.selected, key=lambda one: not one.named)
        return replace(self, selected=tuple(selected), prediction=self.problem.prediction(_answers(selected)))


def search(problem: Problem) -> SearchResult:
    """Find what the model leaves out."""
    found = list(measured_gears(problem))
    problem = replace(problem, asked=[*problem.asked, *mounted_otherwise(problem)])
    without_findings, single, best = problem.prediction([]), list[Answer](), list[Answer]()
    out: set[object] = set()
    total = 1.0
    for _ in range(TURNS):
        problem, found = only_once(problem, found)
        prediction = problem.prediction(_answers(found))
        best = ranked(problem, prediction, found)
        single, total = single or best, total_prior(best, problem)
        open_ = [one for one in best if one.candidate.key not in out and _material(one, without_findings)]
        one = judged(open_, total, partial(by_blocks, prediction))
        if one is None:
            break
        settled, stay = _settled(problem, [*found, one])
        gone = _keys([*found, one]) - _keys(stay)
        if gone and _less_probable(settled, stay, found):
            out.add(one.answer.candidate.key)  # it takes out what explains more
            continue
        problem, found = settled, stay
        # What went out once is not asked for again: it would come and go.
        out |= gone
    found = _checked(problem, found, without_findings, total)
    problem = _nominal_where_better(problem, found, without_findings)
    taken = _keys(found)
    return SearchResult(
        problem,
        tuple(found),
        problem.prediction(_answers(found)),
        without_findings,
        tuple(single),
        tuple(one for one in best if one.candidate.key not in taken),
        total,
    )


def _keys(found: Sequence[Selected]) -> set[object]:
    return {one.answer.candidate.key for one in found}


def _less_probable(problem: Problem, some: Sequence[Selected], others: Sequence[Selected]) -> bool:
    """Whether blocks are less probable with some findings than with others."""
    one, other = (problem.prediction(_answers(found)) for found in (some, others))
    independent = other.weighting.independent
    gain = one.log_probability(one.errors, independent) - other.log_probability(other.errors, independent)
    return float(gain.sum()) < 0.0


def _material(one: Answer, without_findings: Prediction) -> bool:
    """Whether an effect matters beside what the nominal model misses on the joint that shows it best."""
    joint = int(np.argmax(one.by_joint))
    less = float((one.predicted - one.errors)[:, joint].sum())
    return less > MATERIAL * float(without_findings.errors[:, joint].sum()) or one.relief > CERTAIN_ODDS


def _checked(
    problem: Problem, found: list[Selected], without_findings: Prediction, total: float
) -> list[Selected]:
    """Findings that stand beside all others, with their odds beside those that are left after every check."""
    for _ in range(TURNS):
        found = _beside_all(problem, found, total)
        left = _never_worse(problem, found, without_findings, total)
        if _keys(left) == _keys(found):
            return left
        found = left
    return found


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
    prediction = problem.prediction(_answers(others))
    shapes = [pair for pair in problem.asked if pair[0].key == one.answer.candidate.key]
    for answer in sorted(ask(prediction, shapes), key=lambda answer: -answer.gain):
        shaped = colouring(prediction, answer).chosen_as(one.answer)
        again = _judged_as(prediction, one, shaped, others, total)
        if again is None or again.answer.candidate.key != one.answer.candidate.key:
            break
        if np.max(_held_out(problem, [*others, again], without_findings)) <= WORSE**2:
            return [again]
    return []


def _nominal_where_better(
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
    now = problem.prediction(_answers(found))
    return now.power(now.errors, which) / least


def _beside_all(problem: Problem, found: list[Selected], total: float) -> list[Selected]:
    """Findings each in its best shape, and compared anew with what else it may be, beside all others.

    One that is not credible beside them goes.
    """
    whole = problem.prediction(_answers(found))
    for one in found:
        if one.once or not (one.others or one.answer.candidate.bounds):
            continue
        place, others = found.index(one), [other for other in found if other is not one]
        prediction = problem.prediction(_answers(others), whole)
        first = _in_shape(problem, prediction, one.answer)
        again = _judged_as(prediction, one, first, others, total)
        found = [*found[:place], *([again] if again else []), *found[place + 1 :]]
    return found


def _judged_as(
    prediction: Prediction, one: Selected, shaped: Answer, others: Sequence[Selected], total: float
) -> Selected | None:
    """A finding in another shape compared anew with its alternatives, beside others; None if not credible."""
    keys = {other.answer.candidate.key for other in others}
    rivals = [answer for answer, _ in one.not_excluded if answer.candidate.key not in keys]
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
    return refined(prediction, again[0].chosen_as(answer), problem.runs).chosen_as(answer)


def total_prior(best: Sequence[Answer], problem: Problem) -> float:
    """Sum of the prior weights of all hypotheses."""
    by_key = {candidate.key: candidate.prior for candidate, _ in problem.asked}
    return float(sum((by_key | {one.candidate.key: one.candidate.prior for one in best}).values()))


def ranked(problem: Problem, prediction: Prediction, found: Sequence[Selected]) -> list[Answer]:
    """One answer for each hypothesis beside what was found, the most probable first."""
    taken = {one.answer.candidate.key for one in found}
    asked = [pair for pair in problem.asked if pair[0].key not in taken]
    for kind in kinds().values():
        rest = kind.ask_of_rest(problem.model, prediction, problem.runs) if kind.ask_of_rest else ()
        asked += [(one, Thinned.of(one, problem.runs)) for one in rest if one.key not in taken]
    best = _by_hypothesis(ask(prediction, asked))
    foremost = levelled(prediction, best[:COLOURED])
    foremost.sort(key=lambda one: -one.gain)
    for place, one in enumerate(foremost[:REFINE]):
        if one.candidate.bounds and one.gain > NEAR * foremost[0].gain > 0.0:
            grid = [pair for pair in asked if pair[0].key == one.candidate.key]
            foremost[place] = refined(prediction, one, problem.runs, grid if one.candidate.among == 1 else ())
    return sorted([*foremost, *best[COLOURED:]], key=lambda one: -one.gain)


def _by_hypothesis(answers: Sequence[Answer]) -> list[Answer]:
    """The best shape of each, at the cost of having chosen it, the most probable first."""
    groups: dict[object, list[Answer]] = {}
    for one in answers:
        groups.setdefault(one.candidate.key, []).append(one)
    found = []
    for group in groups.values():
        best = max(group, key=lambda one: one.gain)
        gain, odds = (float(np.logaddexp.reduce(own) - np.log(len(group))) for own in _measures(group))
        choice = best.choice + max(best.odds - odds, 0.0)
        found.append(replace(best, cost=best.cost + best.gain - gain, choice=choice))
    return sorted(found, key=lambda one: -one.gain)


def _measures(group: Sequence[Answer]) -> tuple[list[float], list[float]]:
    return [one.gain for one in group], [one.odds for one in group]


def _answers(found: Sequence[Selected]) -> list[Answer]:
    return [one.answer for one in found]


def _settled(problem: Problem, found: list[Selected]) -> tuple[Problem, list[Selected]]:
    """Findings that are each still needed beside the one that came last, at the load they leave."""
    problem, answers = problem.bearing(_answers(found))
    found = [one._replace(answer=answer) for one, answer in zip(found, answers, strict=True)]
    whole = problem.prediction(_answers(found))
    for one in [one for one in found[:-1] if not one.once]:
        others = [other for other in found if other is not one]
        again = again_beside(problem, one.answer, _answers(others), whole)
        again = again or _in_allowed_shape(problem, one.answer, _answers(others), whole)
        if again is None or again.gain + log_prior(again, len(problem.tried)) < CERTAIN_ODDS:
            found = others
            continue
        # Beside others a coefficient may have come to a limit of physics, or left it.
        bounded = replace(
            one.answer,
            candidate=again.candidate,
            columns=again.columns,
            values=again.values,
            free=again.free,
        )
        found = [other._replace(answer=bounded) if other is one else other for other in found]
    return problem, found


def again_beside(
    problem: Problem, answer: Answer, others: Sequence[Answer], near: Prediction
) -> Answer | None:
    """The answer of the same candidate beside some others; None where physics excludes it there."""
    prediction = problem.prediction(others, near)
    again = ask(prediction, [(answer.candidate, answer.columns)])
    return colouring(prediction, again[0]).chosen_as(answer) if again else None


def _in_allowed_shape(
    problem: Problem, answer: Answer, others: Sequence[Answer], near: Prediction
) -> Answer | None:
    """The same effect in its most probable shape that physics allows beside some others, if any.

    The most probable shape is often the last that is allowed: beside others it is not.
    """
    shapes = [pair for pair in problem.asked if pair[0].key == answer.candidate.key]
    if len(shapes) < 2:
        return None
    prediction = problem.prediction(others, near)
    again = max(ask(prediction, shapes), key=lambda one: one.gain, default=None)
    return colouring(prediction, again).chosen_as(answer) if again else None
