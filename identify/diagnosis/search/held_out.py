"""Held out: what runs that are only predicted say of a hypothesis, by how much they gain from it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import stats

from ..blocks.block_likelihood import all_or_nothing, amplitude
from ..questions.block_answer import CERTAIN_ODDS, Answer, against_all
from ..questions.comparison import relative_change
from .problem import Problem
from .selected import Selected, answers_of, log_prior

PROVEN = 0.95
"""Probability of the interval of what a name explains, which must not contain zero."""
FEW = 3
"""Blocks below which their scatter says nothing about the effect on them."""


class Hint(NamedTuple):
    """What runs held out show, and those that were fitted do not: one of them has to be fitted to find it."""

    answer: Answer  # beside all findings
    odds: float  # logarithm of the odds that it is there, by the runs held out alone

    @property
    def joint(self) -> int:
        """Where runs held out show it best, from 0."""
        return int(np.argmax(self.answer.gains[~self.answer.fitted].sum(axis=0)))


def hints(left: Sequence[Answer], total: float) -> list[Hint]:
    """Of each joint the hypothesis that runs held out support, and fitted blocks do not contradict.

    Args:
        left: Answers beside all findings.
        total: Sum of the prior weights of all hypotheses.
    """
    best: dict[int, Hint] = {}
    for answer in left:
        hint = Hint(answer, odds_held_out(answer, total))
        undecided = 0.0 < float(answer.by_joint.sum()) + answer.relief and answer.gain < CERTAIN_ODDS
        held = ~answer.fitted, hint.joint
        excludes_zero = explains(answer.predicted[held], answer.errors[held])
        supported = hint.odds > CERTAIN_ODDS and undecided and excludes_zero
        if supported and (hint.joint not in best or best[hint.joint].odds < hint.odds):
            best[hint.joint] = hint
    return [best[joint] for joint in sorted(best)]


def odds_held_out(answer: Answer, total: float) -> float:
    """Logarithm of the odds that an effect is there by runs held out alone, with its prior.

    As for fitted blocks: against nothing, and against a misfit that differs from block to block.
    """
    held = ~answer.fitted
    if not np.any(held):
        return -np.inf
    sized = bool(np.any(answer.columns.mean != 0.0))
    along, size = answer.along[held], answer.size[held]
    scatter = all_or_nothing(along, size) if sized else amplitude(along, size).log_odds
    odds = against_all(answer.held_out - answer.cost, scatter - answer.choice)
    return odds + float(np.log(2.0)) + log_prior(answer, total)


def proven(problem: Problem, selected: Sequence[Selected]) -> list[Selected]:
    """The findings, each with whether its effect on fitted blocks and on runs held out excludes zero.

    What it explains beside all other findings counts, on the joint that shows it best. Where stated values of
    the model would make up for it, these prove it, from which they would have to be far off. A finding goes
    that is not proven so and that runs held out do not make credible either: it would move the numbers of the
    others, and explain nothing.
    """

    def is_proven(finding: Selected) -> bool:
        stated = not finding.predicts_held_out or finding.answer.relief > CERTAIN_ODDS
        return stated or _excludes_zero(problem, selected, finding)

    judged = [finding._replace(proven=is_proven(finding)) for finding in selected]
    silent = bool(np.all(problem.blocks.fitted))
    return [one for one in judged if one.proven or silent or one.answer.held_out > CERTAIN_ODDS]


def _excludes_zero(problem: Problem, selected: Sequence[Selected], finding: Selected) -> bool:
    with_it = problem.prediction(answers_of(selected))
    without = problem.prediction([other.answer for other in selected if other is not finding], with_it)
    joint, fitted = int(np.argmax(finding.answer.by_joint)), problem.blocks.fitted
    before, after = without.errors[:, joint], with_it.errors[:, joint]
    return explains(before[fitted], after[fitted]) and explains(before[~fitted], after[~fitted])


def explains(before: np.ndarray, after: np.ndarray) -> bool:
    """Whether squared errors of blocks (k,) become less, by the interval of their relative change.

    True where blocks are too few to say.
    """
    if len(before) < FEW:
        return True
    change, std = relative_change(before, after)
    return change < -stats.t.ppf(PROVEN, len(before) - 1) * std
