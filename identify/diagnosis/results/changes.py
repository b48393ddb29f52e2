"""Changes: what each candidate alone would change, for anyone to check with `identify`."""

from collections.abc import Sequence

import numpy as np

from ..findings.finding import Change
from ..questions.block_answer import Answer
from ..search.problem import Problem

MOST = 20
"""Rows of the table."""


def changes(problem: Problem, single: Sequence[Answer]) -> list[Change]:
    """The candidates that alone predict most, with the change of the joint that gains most.

    Args:
        problem: The runs.
        single: Answers of all candidates, each beside nothing else.
    """
    which = ~problem.blocks.fitted if len(problem.held_out) else np.ones(len(problem.blocks), bool)
    found = [_change(one, which) for one in single if one.gain > 0.0]
    return sorted(found, key=lambda one: one.change)[:MOST]


def _change(answer: Answer, which: np.ndarray) -> Change:
    """Relative change of the squared error of some blocks (k,), and its standard deviation over them."""
    joint = int(np.argmax(answer.by_joint))
    after, before = answer.errors[which, joint], answer.predicted[which, joint]
    ratio = float(after.sum() / max(float(before.sum()), 1e-300))
    count = len(after)
    scatter = float(np.sum((after - ratio * before) ** 2)) * count / max(count - 1, 1)
    std = np.sqrt(scatter) / max(float(before.sum()), 1e-300)
    return Change(
        answer.candidate.effect, answer.candidate.joints, joint, ratio - 1.0, float(std), answer.gain
    )
