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
from .checks import checked, nominal_where_better
from .link_encoders import measured_gears
from .mounting import mounted_otherwise
from .once import only_once
from .problem import Problem
from .selected import CERTAIN_ODDS, Selected, answers_of, judged, keys_of, log_prior

TURNS = 16
"""Times that something is added, at most: what came in may go out again for something better."""
COLOURED = 14
"""Hypotheses whose answers are weighed with the colour of what they leave."""
REFINE = 3
"""Hypotheses whose shape is refined before the best is chosen, and as many that only their shape excludes."""
MATERIAL = FORMULA**2
"""Share of what the nominal model misses on a joint that an effect explains there at least [-]: as much as
the formula of the greatest effect may leave."""
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
        return replace(
            self, selected=tuple(selected), prediction=self.problem.prediction(answers_of(selected))
        )


def search(problem: Problem) -> SearchResult:
    """Find what the model leaves out."""
    found = list(measured_gears(problem))
    problem = replace(problem, asked=[*problem.asked, *mounted_otherwise(problem)])
    without_findings, single, best = problem.prediction([]), list[Answer](), list[Answer]()
    out: set[object] = set()
    total = 1.0
    for _ in range(TURNS):
        problem, found = only_once(problem, found)
        prediction = problem.prediction(answers_of(found))
        best = ranked(problem, prediction, found)
        single, total = single or best, total_prior(best, problem)
        open_ = [one for one in best if one.candidate.key not in out and _material(one, without_findings)]
        one = judged(open_, total, partial(by_blocks, prediction))
        if one is None:
            break
        settled, stay = _settled(problem, [*found, one])
        gone = keys_of([*found, one]) - keys_of(stay)
        if gone and _less_probable(settled, stay, found):
            out.add(one.answer.candidate.key)  # it takes out what explains more
            continue
        problem, found = settled, stay
        # What went out once is not asked for again: it would come and go.
        out |= gone
    found = checked(problem, found, without_findings, total)
    problem = nominal_where_better(problem, found, without_findings)
    taken = keys_of(found)
    return SearchResult(
        problem,
        tuple(found),
        problem.prediction(answers_of(found)),
        without_findings,
        tuple(single),
        tuple(one for one in best if one.candidate.key not in taken),
        total,
    )


def _less_probable(problem: Problem, some: Sequence[Selected], others: Sequence[Selected]) -> bool:
    """Whether blocks are less probable with some findings than with others."""
    one, other = (problem.prediction(answers_of(found)) for found in (some, others))
    independent = other.weighting.independent
    gain = one.log_probability(one.errors, independent) - other.log_probability(other.errors, independent)
    return float(gain.sum()) < 0.0


def _material(one: Answer, without_findings: Prediction) -> bool:
    """Whether an effect matters beside what the nominal model misses on the joint that shows it best.

    By the variance that blocks share: one that goes where no other goes is predicted badly by any effect.
    """
    assert one.independent is not None
    errors = np.stack([one.predicted, one.errors, without_findings.errors])
    variance = without_findings.common_variance(errors, one.independent)
    before, after, nominal = variance[:, np.argmax(one.by_joint)]
    return bool(before - after > MATERIAL * nominal) or one.relief > CERTAIN_ODDS


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
    answers = ask(prediction, asked, strange=True)
    strange = [one for one in _by_hypothesis(answers) if one.strange]
    best = [*_by_hypothesis([one for one in answers if not one.strange]), *strange]
    best.sort(key=lambda one: -one.gain)
    foremost = levelled(prediction, best[:COLOURED])
    foremost.sort(key=lambda one: -one.gain)
    for place in _worth_refining(foremost):
        one = foremost[place]
        grid = [pair for pair in asked if pair[0].key == one.candidate.key]
        foremost[place] = refined(prediction, one, problem.runs, grid if one.candidate.among == 1 else ())
    every = sorted([*foremost, *best[COLOURED:]], key=lambda one: -one.gain)
    first = {one.candidate.key: one for one in reversed(every) if not one.strange}
    return [one for one in every if first.get(one.candidate.key) is one]


def _worth_refining(foremost: Sequence[Answer]) -> list[int]:
    """Places of those whose finer shape may be the foremost, and of those that only this shape excludes.

    Each so many at most; the second where they would be credible.
    """
    near = [k for k, one in enumerate(foremost) if one.gain > NEAR * foremost[0].gain > 0.0][:REFINE]
    strange = [k for k, one in enumerate(foremost) if one.strange and one.gain > CERTAIN_ODDS]
    places = [*near, *[k for k in strange if k not in near][:REFINE]]
    return [k for k in places if foremost[k].candidate.bounds]


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


def _settled(problem: Problem, found: list[Selected]) -> tuple[Problem, list[Selected]]:
    """Findings that are each still needed beside the one that came last, at the load they leave."""
    problem, answers = problem.bearing(answers_of(found))
    found = [one._replace(answer=answer) for one, answer in zip(found, answers, strict=True)]
    whole = problem.prediction(answers_of(found))
    for one in [one for one in found[:-1] if not one.once]:
        others = [other for other in found if other is not one]
        again = again_beside(problem, one.answer, answers_of(others), whole)
        again = again or _in_allowed_shape(problem, one.answer, answers_of(others), whole)
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
