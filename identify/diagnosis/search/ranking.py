"""Ranking: every hypothesis in its best shape given the findings, most probable first."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from heapq import nlargest

import numpy as np

from ..blocks.prediction import Prediction
from ..candidates import KINDS
from ..questions.block_answer import CERTAIN_ODDS, Answer, compute_scatter_odds
from ..questions.candidate import Candidate
from ..questions.comparison import competing, equally_weighted
from ..questions.question import ask
from ..questions.shape import refined
from .problem import Pairs, Problem
from .selected import EXCLUDED_ODDS, Selected, keys_of

COLORED = 14
"""Number of top hypotheses whose answers account for the autocorrelation of the residual."""
FORMED = 2 * COLORED
"""Number of top hypotheses whose columns are formed at the present load."""
REFINE = 3
"""Number of top hypotheses whose shape is refined, and of those that only their grid shape excludes."""
NEAR = 0.5
"""Gain relative to the best, below which a finer shape cannot make a hypothesis the best [-]."""

Shapes = dict[object, Answer]
"""Answers in the best shape of an earlier ranking, by hypothesis: a cache, as shapes are slow to search."""


def total_prior(problem: Problem) -> float:
    """Sum of the prior weights of all hypotheses."""
    return float(sum({candidate.key: candidate.prior for candidate, _ in problem.candidates}.values()))


def ranked(
    problem: Problem,
    prediction: Prediction,
    selected: Sequence[Selected],
    shapes: Shapes,
    joints: np.ndarray | None = None,
) -> list[Answer]:
    """One answer for each hypothesis given the findings, most probable first.

    Shapes that are refined here are added to `shapes`. By default, hypotheses act on all joints.
    """
    present_keys, present = keys_of(selected), [finding.answer.candidate for finding in selected]
    allowed = set(range(prediction.joints) if joints is None else joints.tolist())

    def wanted(candidate: Candidate, acting: Sequence[int] | np.ndarray) -> bool:
        fresh = candidate.key not in present_keys and not candidate.covered(present)
        return fresh and not allowed.isdisjoint(acting)

    known = [answer for answer in shapes.values() if wanted(answer.candidate, answer.columns.joints)]
    earlier = [answer for answer in known if not answer.strange]
    pairs, answers = _answers_by_load(problem, prediction, wanted)
    strange = [answer for answer in _by_hypothesis(answers) if answer.strange]
    best = [*_by_hypothesis([answer for answer in answers if not answer.strange]), *strange]
    best = _with_known_shapes(best, _in_same_shapes(problem, prediction, earlier))
    top = sorted(equally_weighted(prediction, best[:COLORED]), key=lambda answer: -answer.gain)
    for place in _worth_refining(top, known):
        candidate = top[place].candidate
        grid = [pair for pair in pairs if pair[0].key == candidate.key]
        fine = refined(prediction, top[place], problem.runs, grid if candidate.among == 1 else ())
        top[place] = fine
        shapes[candidate.key] = shapes.get(candidate.key, fine) if fine.strange else fine
    ranking = sorted([*top, *best[COLORED:]], key=lambda answer: -answer.gain)
    first = {answer.candidate.key: answer for answer in reversed(ranking) if not answer.strange}
    return [answer for answer in ranking if first.get(answer.candidate.key) is answer]


def _answers_by_load(
    problem: Problem,
    prediction: Prediction,
    wanted: Callable[[Candidate, Sequence[int] | np.ndarray], bool],
) -> tuple[Pairs, list[Answer]]:
    """Candidates that `wanted` accepts, and their answers.

    A load changes little from one finding to the next, and columns of gears take long. So columns at an
    earlier load rank all hypotheses, and only those of the first are formed again, in shapes that are not
    excluded.
    """
    listed = [pair for pair in problem.last_formed if wanted(pair[0], pair[1].joints)]
    pairs = list(listed)
    for kind in KINDS.values():
        suggested = kind.ask_of_rest(problem.model, prediction, problem.runs) if kind.ask_of_rest else ()
        found = [candidate for candidate in suggested if wanted(candidate, candidate.joints)]
        pairs += [(candidate, problem.columns_of(candidate)) for candidate in found]
    answers = ask(prediction, pairs, strange=True)
    gains: dict[object, float] = {}
    for answer in answers:
        gains[answer.candidate.key] = max(answer.gain, gains.get(answer.candidate.key, 0.0))
    least = {key: gains[key] - EXCLUDED_ODDS for key in nlargest(FORMED, gains, key=lambda key: gains[key])}
    likely = {id(a.candidate) for a in answers if a.gain > max(least.get(a.candidate.key, np.inf), 0.0)}
    fresh = dict(problem.at_load([pair for pair in listed if id(pair[0]) in likely]))
    moved = [
        (candidate, fresh[candidate]) for candidate, old in pairs if fresh.get(candidate, old) is not old
    ]
    anew = {id(candidate) for candidate, _ in moved}
    answers = [answer for answer in answers if id(answer.candidate) not in anew]
    return [(candidate, fresh.get(candidate, columns)) for candidate, columns in pairs], [
        *answers,
        *ask(prediction, moved, strange=True),
    ]


def _in_same_shapes(problem: Problem, prediction: Prediction, earlier: Sequence[Answer]) -> list[Answer]:
    """New answers in the shapes of earlier ones, at the cost of the earlier choice."""
    pairs = [(old.candidate, problem.columns_at_load(old.candidate, old.columns)) for old in earlier]
    by_candidate = {id(old.candidate): old for old in earlier}
    return [answer.chosen_as(by_candidate[id(answer.candidate)]) for answer in ask(prediction, pairs)]


def _with_known_shapes(grid: Sequence[Answer], known: Sequence[Answer]) -> list[Answer]:
    """Answers, most probable first, each in its known shape unless a grid shape fits the blocks better."""
    by_key = {answer.candidate.key: answer for answer in known}
    fits = {answer.candidate.key: answer.gain + answer.cost for answer in known}
    better = [
        answer for answer in grid if answer.gain + answer.cost > fits.get(answer.candidate.key, -np.inf)
    ]
    for answer in better:
        if not answer.strange:
            by_key.pop(answer.candidate.key, None)
    return sorted([*better, *by_key.values()], key=lambda answer: -answer.gain)


def _worth_refining(top: Sequence[Answer], known: Sequence[Answer]) -> list[int]:
    """Indices of answers not refined earlier that a finer shape may make the best, or physically possible.

    A hypothesis that no shape made possible is not tried again.
    """
    earlier, impossible = (
        {id(answer.candidate) for answer in known},
        {a.candidate.key for a in known if a.strange},
    )
    least = max(NEAR * top[0].gain, 0.0) if top else 0.0
    near = [k for k, answer in enumerate(top) if answer.gain > least and competing(answer, top[0])]
    places = dict.fromkeys([*near[:REFINE], *[k for k in near if top[k].strange][:REFINE]])
    untried = [k for k in places if top[k].candidate.bounds and id(top[k].candidate) not in earlier]
    return [k for k in untried if not (top[k].strange and top[k].candidate.key in impossible)]


def _by_hypothesis(answers: Sequence[Answer]) -> list[Answer]:
    """The best shape of each hypothesis, at the cost of having chosen it, most probable first."""
    groups: dict[object, list[Answer]] = {}
    for answer in answers:
        groups.setdefault(answer.candidate.key, []).append(answer)
    shaped = [
        group for group in groups.values() if len(group) > 1 and max(answer.gain for answer in group) > 0.0
    ]
    compute_scatter_odds([answer for group in shaped for answer in group])
    best = [_chosen(group) for group in groups.values()]
    return sorted(best, key=lambda answer: -answer.gain)


def _with_fewest_numbers(group: Sequence[Answer]) -> Answer:
    """The best shape; one with fewer numbers unless the best is credible against it."""
    best = max(group, key=lambda answer: answer.gain)
    nearly_best = [answer for answer in group if answer.gain > best.gain - CERTAIN_ODDS]
    return min(nearly_best, key=lambda answer: (answer.numbers, -answer.gain))


def _chosen(group: Sequence[Answer]) -> Answer:
    """The best shape at the cost of having chosen it: no more probable than the average shape."""
    best = _with_fewest_numbers(group)
    if len(group) == 1 or best.gain <= 0.0:  # the cost would change nothing
        return best
    gain, odds = (
        float(np.logaddexp.reduce(logs) - np.log(len(group)))
        for logs in ([answer.gain for answer in group], [answer.scatter_odds for answer in group])
    )
    choice = best.choice + max(best.scatter_odds - odds, 0.0)
    return replace(best, cost=best.cost + max(best.gain - gain, 0.0), choice=choice)
