"""Comparison: answers weighed alike, and which of two predicts better, block by block."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..blocks.block_likelihood import all_or_nothing, trusted
from ..blocks.prediction import Prediction
from .block_answer import Answer, against_all
from .question import predicted_change

SEEN = 1.0
"""Logarithm of the probability gained from which on a joint counts as seeing an effect."""


def colouring(prediction: Prediction, answer: Answer) -> Answer:
    """The answer with as many independent rows as the effect has through what it leaves."""
    return weighed(prediction, answer, _independent(prediction, answer))


def _independent(prediction: Prediction, answer: Answer) -> np.ndarray:
    torque = np.zeros(prediction.rows.difference.shape)
    torque[:, answer.columns.joints] = answer.torque
    return prediction.independent_of(torque)


def weighed(prediction: Prediction, answer: Answer, independent: np.ndarray) -> Answer:
    """The answer with so many independent rows over all rows (n,): answers are compared by the same."""
    gains = prediction.log_probability(answer.errors, independent) - prediction.log_probability(
        prediction.errors, independent
    )
    return replace(answer, gains=gains, independent=independent)


def levelled(prediction: Prediction, answers: Sequence[Answer]) -> list[Answer]:
    """The answers with as many independent rows of each joint as the best of that joint leaves.

    Weighed each with its own, one that leaves more of a misfit could be ahead only because it is faster.
    """
    if not answers:
        return []
    coloured: dict[int, np.ndarray] = {}
    independent = np.ones(prediction.joints)
    for joint in range(prediction.joints):
        first = max(range(len(answers)), key=lambda place: float(answers[place].by_joint[joint]))
        if first not in coloured:
            coloured[first] = _independent(prediction, answers[first])
        independent[joint] = coloured[first][joint]
    return [weighed(prediction, one, independent) for one in answers]


def seeing(one: Answer) -> np.ndarray:
    """Which joints see an answer, shape (n,); where only priors support it, those that it gives torque to."""
    seen = one.by_joint > SEEN
    return seen if np.any(seen) else np.isin(np.arange(len(seen)), one.columns.joints)


def competing(one: Answer, other: Answer) -> bool:
    """Whether one joint sees both, so that they may explain the same."""
    return bool(np.any(seeing(one) & seeing(other)))


def by_blocks(prediction: Prediction, one: Answer, other: Answer) -> float:
    """Logarithm of the odds that blocks left out have what one answer predicts, and not what another does.

    Where two predict differently, a block shows how much of the difference it has: all of it if the first is
    right, nothing if the other is. Joints that see neither do not count. The prediction is without either.
    """
    first, second = predicted_change(prediction, one), predicted_change(prediction, other)
    apart = (first - second) * prediction.rows.weight
    left = prediction.left_out_residual - second
    noise, share = 1.0 / prediction.weighting.variance, prediction.weighting.independent
    errors = share * noise * 0.5 * (one.errors + other.errors)
    seen = seeing(one) | seeing(other)
    sound = seen * share * noise * trusted(errors, share * prediction.sums.counts)
    starts = [rows.start for rows in prediction.blocks.rows]
    along, size = (
        np.sum(np.add.reduceat(product, starts, axis=0) * sound, axis=1)
        for product in (left * apart, apart**2)
    )
    fitted = prediction.blocks.fitted
    return all_or_nothing(along[fitted], size[fitted])


def better(one: Answer, other: Answer, blocks: float, prior: float = 0.0) -> float:
    """Logarithm of the odds that one predicts better than another, by those of `by_blocks` and of priors.

    Blocks speak for the one that makes them more probable, against the other and against a misfit that is
    neither and differs from block to block. What shapes cost and what priors say is known without blocks.
    """
    gain = float(one.by_joint.sum() - other.by_joint.sum())
    sign = 1.0 if gain > 0.0 else -1.0
    evidence = sign * max(against_all(sign * gain, sign * blocks), 0.0)
    return evidence + other.cost - one.cost + one.relief - other.relief + prior


def relative_change(before: np.ndarray, after: np.ndarray) -> tuple[float, float]:
    """Relative change of the sum of squared errors of blocks (k,), and its standard deviation over blocks."""
    count, total = len(after), max(float(before.sum()), 1e-300)
    ratio = float(after.sum()) / total
    scatter = float(np.sum((after - ratio * before) ** 2)) * count / max(count - 1, 1)
    return ratio - 1.0, float(np.sqrt(scatter)) / total
