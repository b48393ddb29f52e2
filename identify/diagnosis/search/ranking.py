"""Ranking: every hypothesis in its best shape beside some findings, the most probable first."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..blocks.prediction import Prediction
from ..candidates import KINDS
from ..questions.block_answer import Answer, scattered
from ..questions.candidate import Candidate
from ..questions.comparison import competing, levelled
from ..questions.question import ask
from ..questions.shape import refined
from .problem import Problem
from .selected import Selected, keys_of

COLOURED = 14
"""Hypotheses whose answers are weighed with the colour of what they leave."""
REFINE = 3
"""Hypotheses whose shape is refined before the best is chosen, and as many that only their shape excludes."""
NEAR = 0.5
"""Share of the foremost gain below which no finer shape makes a hypothesis the foremost [-]."""

Shapes = dict[object, Answer]
"""Answers in the best shape of an earlier ranking, by hypothesis: a cache of what is slow to search."""


def total_prior(best: Sequence[Answer], problem: Problem) -> float:
    """Sum of the prior weights of all hypotheses."""
    by_key = {candidate.key: candidate.prior for candidate, _ in problem.asked}
    return float(sum((by_key | {one.candidate.key: one.candidate.prior for one in best}).values()))


def ranked(
    problem: Problem,
    prediction: Prediction,
    selected: Sequence[Selected],
    shapes: Shapes,
    joints: np.ndarray | None = None,
) -> list[Answer]:
    """One answer for each hypothesis beside findings, the most probable first.

    Of all joints, or of some. Shapes are asked for beside the grid; those that are refined here are put in.
    """
    taken, present = keys_of(selected), [one.answer.candidate for one in selected]
    near = set(range(prediction.joints) if joints is None else joints.tolist())

    def wanted(candidate: Candidate, acting: Sequence[int] | np.ndarray) -> bool:
        fresh = candidate.key not in taken and not candidate.covered(present)
        return fresh and not near.isdisjoint(acting)

    asked = problem.pairs(wanted)
    for kind in KINDS.values():
        rest = kind.ask_of_rest(problem.model, prediction, problem.runs) if kind.ask_of_rest else ()
        asked += [(one, problem.columns_of(one)) for one in rest if wanted(one, one.joints)]
    before = [one for one in shapes.values() if wanted(one.candidate, one.columns.joints)]
    answers = ask(prediction, asked, strange=True)
    strange = [one for one in _by_hypothesis(answers) if one.strange]
    best = [*_by_hypothesis([one for one in answers if not one.strange]), *strange]
    best = _with_known_shapes(best, _again(problem, prediction, before))
    foremost = sorted(levelled(prediction, best[:COLOURED]), key=lambda one: -one.gain)
    for place in _worth_refining(foremost, [one.candidate for one in before]):
        one = foremost[place]
        grid = [pair for pair in asked if pair[0].key == one.candidate.key]
        fine = refined(prediction, one, problem.runs, grid if one.candidate.among == 1 else ())
        foremost[place] = fine
        if not fine.strange:
            shapes[one.candidate.key] = fine
    every = sorted([*foremost, *best[COLOURED:]], key=lambda one: -one.gain)
    first = {one.candidate.key: one for one in reversed(every) if not one.strange}
    return [one for one in every if first.get(one.candidate.key) is one]


def _again(problem: Problem, prediction: Prediction, before: Sequence[Answer]) -> list[Answer]:
    """Answers in the shapes they had, at the cost at which these were chosen."""
    pairs = [(one.candidate, problem.columns_anew(one.candidate, one.columns)) for one in before]
    chosen = {id(one.candidate): one for one in before}
    return [one.chosen_as(chosen[id(one.candidate)]) for one in ask(prediction, pairs)]


def _with_known_shapes(grid: Sequence[Answer], known: Sequence[Answer]) -> list[Answer]:
    """The most probable first, each in the shape known before where none of the grid fits blocks better."""
    by_key = {one.candidate.key: one for one in known}
    fits = {one.candidate.key: one.gain + one.cost for one in known}
    better = [one for one in grid if one.gain + one.cost > fits.get(one.candidate.key, -np.inf)]
    for one in better:
        if not one.strange:
            by_key.pop(one.candidate.key, None)
    return sorted([*better, *by_key.values()], key=lambda one: -one.gain)


def _worth_refining(foremost: Sequence[Answer], before: Sequence[Candidate]) -> list[int]:
    """Places of those, not refined before, whose finer shape may be the foremost, or may not be excluded."""
    least = max(NEAR * foremost[0].gain, 0.0) if foremost else 0.0
    near = [k for k, one in enumerate(foremost) if one.gain > least and competing(one, foremost[0])]
    places = dict.fromkeys([*near[:REFINE], *[k for k in near if foremost[k].strange][:REFINE]])
    return [k for k in places if foremost[k].candidate.bounds and foremost[k].candidate not in before]


def _by_hypothesis(answers: Sequence[Answer]) -> list[Answer]:
    """The best shape of each, at the cost of having chosen it, the most probable first."""
    groups: dict[object, list[Answer]] = {}
    for one in answers:
        groups.setdefault(one.candidate.key, []).append(one)
    chosen = [group for group in groups.values() if len(group) > 1 and max(one.gain for one in group) > 0.0]
    scattered([one for group in chosen for one in group])
    found = [_chosen(group) for group in groups.values()]
    return sorted(found, key=lambda one: -one.gain)


def _chosen(group: Sequence[Answer]) -> Answer:
    """The best shape at the cost of having chosen it: as probable as all are on average."""
    best = max(group, key=lambda one: one.gain)
    if len(group) == 1 or best.gain <= 0.0:  # nothing comes of it either way
        return best
    gain, odds = (
        float(np.logaddexp.reduce(every) - np.log(len(group)))
        for every in ([one.gain for one in group], [one.scatter_odds for one in group])
    )
    choice = best.choice + max(best.scatter_odds - odds, 0.0)
    return replace(best, cost=best.cost + best.gain - gain, choice=choice)
