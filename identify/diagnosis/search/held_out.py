"""Held out: how far held-out runs support or contradict a hypothesis."""

from collections.abc import Sequence

import numpy as np
from scipy import stats

from ..blocks.block_likelihood import above_zero, all_or_nothing
from ..candidates import dependence_of
from ..findings.residuals import Hinted
from ..questions.block_answer import CERTAIN_ODDS, Answer, against_all
from ..questions.comparison import relative_change
from .problem import Problem
from .selected import Selected, answers_of, log_prior

PROVEN = 0.95
"""Confidence level of the interval of what a finding explains, which must exclude zero [-]."""
FEW = 3
"""Fewest blocks whose scatter says anything about an effect."""


def hints(answers: Sequence[Answer], total: float) -> tuple[Hinted, ...]:
    """Best hypothesis for each joint that held-out runs support and fitted blocks do not contradict.

    Args:
        answers: Answers with all findings in the model.
        total: Sum of the prior weights of all hypotheses.
    """
    best: dict[int, tuple[float, Hinted]] = {}
    for answer in answers:
        undecided = 0.0 < float(answer.by_joint.sum()) + answer.relief and answer.gain < CERTAIN_ODDS
        odds, hint = odds_held_out(answer, total), _hint(answer)
        held = ~answer.fitted, hint.joint
        excludes_zero = explains(answer.predicted[held], answer.errors[held])
        supported = odds > CERTAIN_ODDS and undecided and excludes_zero
        if supported and odds > best.get(hint.joint, (-np.inf,))[0]:
            best[hint.joint] = odds, hint
    return tuple(best[joint][1] for joint in sorted(best))


def _hint(answer: Answer) -> Hinted:
    """An effect as held-out runs show it, on the joint that shows it best."""
    held_out, candidate = ~answer.fitted, answer.candidate
    joint = int(np.argmax(answer.gains[held_out].sum(axis=0)))
    change, std = relative_change(answer.predicted[held_out, joint], answer.errors[held_out, joint])
    depends_on = dependence_of(candidate) or candidate.effect
    return Hinted(
        candidate.effect, joint, depends_on, float(answer.gain), float(answer.held_out), change, std
    )


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
