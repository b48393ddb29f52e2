"""Held out: how far held-out runs support or contradict a hypothesis."""

from collections.abc import Sequence

import numpy as np
from scipy import stats

from ..blocks.block_likelihood import above_zero, all_or_nothing
from ..questions.block_answer import CERTAIN_ODDS, Answer, against_all
from ..questions.comparison import relative_change
from .problem import Problem
from .selected import Selected, answers_of, log_prior

PROVEN = 0.95
"""Confidence level of the interval of what a finding explains, which must exclude zero [-]."""
FEW = 3
"""Fewest blocks whose scatter says anything about an effect."""


def odds_held_out(answer: Answer, total: float) -> float:
    """Log odds that an effect is there, from its prior and the held-out runs alone.

    The alternatives are those of fitted blocks: no effect, or a misfit that differs from block to block.
    """
    held = ~answer.fitted
    if not np.any(held):
        return -np.inf
    scatter = (all_or_nothing if answer.sized else above_zero)(answer.along[held], answer.size[held])
    odds = against_all(answer.held_out - answer.cost, float(scatter) - answer.choice)
    return odds + float(np.log(2.0)) + log_prior(answer, total)


def proven(problem: Problem, selected: Sequence[Selected]) -> list[Selected]:
    """The findings, each marked by whether its effect on fitted blocks and on held-out runs excludes zero.

    Only what it explains beyond all other findings counts, on the joint that shows it best. A finding is also
    proven if nominal values could only replace it by being far off. A finding that is neither proven nor made
    credible by held-out runs is removed: it would shift the values of the others and explain nothing.
    """

    def is_proven(finding: Selected) -> bool:
        stated = not finding.predicts_held_out or finding.answer.relief > CERTAIN_ODDS
        return stated or _excludes_zero(problem, selected, finding)

    judged = [finding._replace(proven=is_proven(finding)) for finding in selected]
    no_held_out = bool(np.all(problem.blocks.fitted))
    return [
        finding
        for finding in judged
        if finding.proven or no_held_out or finding.answer.held_out > CERTAIN_ODDS
    ]


def _excludes_zero(problem: Problem, selected: Sequence[Selected], finding: Selected) -> bool:
    with_finding = problem.prediction(answers_of(selected))
    without = problem.prediction([other.answer for other in selected if other is not finding], with_finding)
    joint, fitted = finding.answer.joint, problem.blocks.fitted
    before, after = without.errors[:, joint], with_finding.errors[:, joint]
    return explains(before[fitted], after[fitted]) and explains(before[~fitted], after[~fitted])


def explains(before: np.ndarray, after: np.ndarray) -> bool:
    """Whether squared errors of blocks (k,) decrease: the interval of their relative change excludes zero.

    True where there are too few blocks to tell.
    """
    if len(before) < FEW:
        return True
    change, std = relative_change(before, after)
    return change < -stats.t.ppf(PROVEN, len(before) - 1) * std
