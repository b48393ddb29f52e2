"""Held out: how far held-out runs support or contradict a hypothesis."""

from collections.abc import Sequence

import numpy as np
from scipy import stats

from ..questions.block_answer import CERTAIN_ODDS, Answer
from ..questions.comparison import relative_change
from .problem import Problem
from .selected import Selected, answers_of, odds_on_any_joint

PROVEN = 0.95
"""Confidence level of the interval of what a finding explains, which must exclude zero [-]."""
FEW = 3
"""Fewest blocks whose scatter says anything about an effect."""


def shown_by_held_out(answers: Sequence[Answer], total: float) -> list[Selected]:
    """Best hypothesis for each joint that is credible with the held-out runs, and not without them.

    Such a finding is unproven: it is listed as undecided.
    """
    shown: dict[int, list[tuple[float, Answer]]] = {}
    for answer in answers:
        held = ~answer.fitted
        joint = int(np.argmax(answer.gains[held].sum(axis=0))) if np.any(held) else 0
        gain = answer.held_out - answer.scatter_held_out
        excludes_zero = gain > 0.0 and explains(answer.predicted[held, joint], answer.errors[held, joint])
        odds = odds_on_any_joint(answer, total) + gain if excludes_zero else -np.inf
        if odds > 0.0:
            shown.setdefault(joint, []).append((odds, answer))
    best: dict[int, Selected] = {}
    for hypotheses in shown.values():
        (odds, first), *rivals = sorted(hypotheses, key=lambda pair: -pair[0])
        others = tuple((rival, odds - less) for less, rival in rivals)
        best[id(first)] = Selected(first, odds, others, proven=False)
    return list(best.values())


def proven(problem: Problem, selected: Sequence[Selected]) -> list[Selected]:
    """The findings, each marked by whether its effect on fitted blocks and on held-out runs excludes zero.

    Only what it explains beyond all other findings counts, on the joint whose fitted blocks show that best.
    It is also proven if nominal values could only replace it by being far off.
    """
    return [
        finding._replace(
            proven=not finding.predicts_held_out
            or finding.by_priors
            or _excludes_zero(problem, selected, finding)
        )
        for finding in selected
    ]


def supported(problem: Problem, selected: Sequence[Selected]) -> list[Selected]:
    """The findings that are proven, or that held-out runs make credible.

    Any other finding would shift the values of the others and explain nothing.
    """
    no_held_out = bool(np.all(problem.blocks.fitted))
    judged = proven(problem, selected)
    return [f for f in judged if f.proven or no_held_out or f.answer.held_out > CERTAIN_ODDS]


def _excludes_zero(problem: Problem, selected: Sequence[Selected], finding: Selected) -> bool:
    with_finding = problem.prediction(answers_of(selected))
    without = problem.prediction([other.answer for other in selected if other is not finding], with_finding)
    before, after, fitted = without.errors, with_finding.errors, problem.blocks.fitted
    joints = finding.answer.columns.joints.tolist()
    joint = min(joints, key=lambda j: _upper(before[fitted, j], after[fitted, j]))
    return all(explains(before[blocks, joint], after[blocks, joint]) for blocks in (fitted, ~fitted))


def explains(before: np.ndarray, after: np.ndarray) -> bool:
    """Whether squared errors of blocks (k,) decrease: the interval of their relative change excludes zero.

    True where there are too few blocks to tell.
    """
    if len(before) < FEW:
        return True
    return _upper(before, after) < 0.0


def _upper(before: np.ndarray, after: np.ndarray) -> float:
    """Upper end of the interval of the relative change of the squared errors of blocks (k,)."""
    change, std = relative_change(before, after)
    return float(change + stats.t.ppf(PROVEN, max(len(before) - 1, 1)) * std)
