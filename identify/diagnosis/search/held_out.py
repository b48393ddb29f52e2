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


def shown_by_held_out(answers: Sequence[Answer], total: float) -> list[Selected]:
    """Best hypothesis for each joint that held-out runs show and fitted blocks do not contradict.

    These findings are unproven: fitted blocks do not decide them.

    Args:
        answers: Answers with all findings in the model.
        total: Sum of the prior weights of all hypotheses.
    """
    best: dict[int, tuple[float, Answer]] = {}
    for answer in answers:
        undecided = 0.0 < float(answer.by_joint.sum()) + answer.relief
        odds, held = odds_held_out(answer, total), ~answer.fitted
        joint = int(np.argmax(answer.gains[held].sum(axis=0))) if np.any(held) else 0
        excludes_zero = explains(answer.predicted[held, joint], answer.errors[held, joint])
        supported = odds > CERTAIN_ODDS and undecided and excludes_zero
        if supported and odds > best.get(joint, (-np.inf,))[0]:
            best[joint] = odds, answer
    chosen = {id(answer): (odds, answer) for odds, answer in best.values()}.values()
    return [Selected(answer, odds, proven=False) for odds, answer in chosen]


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
    proven if nominal values could only replace it by being far off.
    """
    return [
        finding._replace(
            proven=not finding.predicts_held_out
            or finding.by_priors
            or _excludes_zero(problem, selected, finding)
        )
        for finding in selected
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
