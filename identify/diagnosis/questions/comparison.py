"""Comparison: answers weighed alike, and which of two predicts better, block by block."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..blocks.block_likelihood import log_odds
from ..blocks.prediction import Prediction
from .block_answer import Answer

LINEAR = 0.03
"""Share by which a torque may be wrong all over [-]: current sensors are linear to a few per cent."""
SEEN = 1.0
"""Logarithm of the probability gained from which on a joint counts as seeing an effect."""


def colouring(prediction: Prediction, answer: Answer) -> Answer:
    """The answer with as many independent rows as the effect has through what it leaves."""
    torque = np.zeros(prediction.rows.difference.shape)
    torque[:, answer.columns.joints] = answer.torque
    return weighed(prediction, answer, prediction.independent_of(torque))


def weighed(prediction: Prediction, answer: Answer, independent: np.ndarray) -> Answer:
    """The answer with so many independent rows over all rows (n,): answers are compared by the same."""
    gains = prediction.log_probability(answer.errors, independent) - prediction.log_probability(
        prediction.errors, independent
    )
    return replace(answer, gains=gains, independent=independent)


def levelled(prediction: Prediction, answers: Sequence[Answer]) -> list[Answer]:
    """The answers with as many independent rows of each joint as what the foremost of that joint leaves has.

    Weighed each with its own, what leaves more of a misfit could come out ahead, only because it is faster.
    """
    if not answers:
        return []
    coloured: dict[int, np.ndarray] = {}
    independent = np.ones(prediction.joints)
    for joint in range(prediction.joints):
        first = max(range(len(answers)), key=lambda place: float(answers[place].by_joint[joint]))
        if first not in coloured:
            torque = np.zeros(prediction.rows.difference.shape)
            torque[:, answers[first].columns.joints] = answers[first].torque
            coloured[first] = prediction.independent_of(torque)
        independent[joint] = coloured[first][joint]
    return [weighed(prediction, one, independent) for one in answers]


def competing(one: Answer, other: Answer) -> bool:
    """Whether both give torque to one joint, and so may explain the same."""
    return bool(np.intersect1d(one.columns.joints, other.columns.joints).size)


def _as_good(one: Answer, other: Answer) -> bool:
    """Whether what two answers leave differs by less than the sensors' error of what is explained.

    So it has to be on every joint that sees either of them.
    """
    seen = (one.by_joint > SEEN) | (other.by_joint > SEEN)
    left = np.array([answer.errors.sum(axis=0) for answer in (one, other)])
    explained = one.predicted.sum(axis=0) - left.min(axis=0)
    return bool(np.all(np.abs(left[0] - left[1])[seen] < LINEAR**2 * explained[seen]))


def better(one: Answer, other: Answer, prior: float = 0.0) -> float:
    """Logarithm of the odds that one predicts better than another, by their blocks.

    The evidence of the blocks is limited by the scatter of the difference over them, and zero where the two
    differ by less than torque may be wrong; what shapes cost, and `prior`, is known without them.
    """
    apart = one.by_block - other.by_block
    if _as_good(one, other):
        apart = np.zeros(len(apart))
    error = float(np.std(apart, ddof=1)) * np.sqrt(len(apart)) + 1e-9
    scatter = log_odds(float(apart.sum()) / error, len(apart) - 1.0)
    return (
        min(float(apart.sum()), max(scatter, 0.0)) + other.cost - one.cost + one.relief - other.relief + prior
    )
