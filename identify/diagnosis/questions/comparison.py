"""Comparison: answers weighted alike, and which of two predicts better, block by block."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..blocks.block_likelihood import all_or_nothing, trusted
from ..blocks.prediction import Prediction
from .block_answer import Answer, against_all
from .question import predicted_change

SEEN = 1.0
"""Gain in log probability from which on a joint counts as seeing an effect."""


def colouring(prediction: Prediction, answer: Answer) -> Answer:
    """The answer with its number of independent rows, from the autocorrelation of its effect and residual."""
    return weighted(prediction, answer, _independent(prediction, answer))


def _independent(prediction: Prediction, answer: Answer) -> np.ndarray:
    torque = np.zeros(prediction.rows.difference.shape)
    torque[:, answer.columns.joints] = answer.torque
    return prediction.independent_of(torque)


def weighted(prediction: Prediction, answer: Answer, independent: np.ndarray) -> Answer:
    """The answer with a given share of independent rows (n,): answers are compared at the same share."""
    gains = prediction.log_probability(answer.errors, independent) - prediction.log_probability(
        prediction.errors, independent
    )
    return replace(answer, gains=gains, independent=independent)


def equally_weighted(prediction: Prediction, answers: Sequence[Answer]) -> list[Answer]:
    """The answers, all with the share of independent rows that the best answer has on each joint.

    If each were weighted with its own share, a faster effect could win despite a larger misfit.
    """
    if not answers:
        return []
    by_best: dict[int, np.ndarray] = {}
    independent = np.ones(prediction.joints)
    for joint in range(prediction.joints):
        first = max(range(len(answers)), key=lambda place: float(answers[place].by_joint[joint]))
        if first not in by_best:
            by_best[first] = _independent(prediction, answers[first])
        independent[joint] = by_best[first][joint]
    return [weighted(prediction, answer, independent) for answer in answers]


def seeing(answer: Answer) -> np.ndarray:
    """Which joints see an effect, shape (n,); if only priors support it, the joints it gives torque to."""
    seen = answer.by_joint > SEEN
    return seen if np.any(seen) else np.isin(np.arange(len(seen)), answer.columns.joints)


def competing(answer: Answer, other: Answer) -> bool:
    """Whether a joint sees both effects, so that they may explain the same."""
    return bool(np.any(seeing(answer) & seeing(other)))


def by_blocks(prediction: Prediction, answer: Answer, other: Answer) -> float:
    """Log odds that left-out blocks contain what one answer predicts rather than what another does.

    Each block shows how much of the difference between the two it contains: all of it if the first is right,
    none if the other is. Joints that see neither do not count.
    """
    first, second = predicted_change(prediction, answer), predicted_change(prediction, other)
    sums, difference = prediction.sums, first - second
    residual = sums.residual(prediction.left_out) - second
    noise, share = 1.0 / prediction.weighting.variance, prediction.weighting.independent
    errors = share * noise * 0.5 * (answer.errors + other.errors)
    seen = seeing(answer) | seeing(other)
    weight = seen * share * noise * trusted(errors, share * sums.counts)
    products = residual * difference, difference**2
    along, size = (np.sum(sums.sums(product) * weight, axis=1) for product in products)
    fitted = prediction.blocks.fitted
    return float(all_or_nothing(along[fitted], size[fitted]))


def better(answer: Answer, other: Answer, blocks: float, prior: float = 0.0) -> float:
    """Log odds that one answer is right rather than another, from blocks, shape costs and priors.

    Blocks favor the answer that makes them more probable, against two alternatives: the other answer, and a
    misfit that is neither and differs from block to block.
    """
    gain = float(answer.by_joint.sum() - other.by_joint.sum())
    sign = 1.0 if gain > 0.0 else -1.0
    evidence = sign * max(against_all(sign * gain, sign * blocks), 0.0)
    return evidence + other.cost - answer.cost + answer.relief - other.relief + prior


def explained_variance(prediction: Prediction, answer: Answer, joint: int) -> tuple[float, float]:
    """Variance of a joint's predicted blocks without an effect, and by how much the effect reduces it."""
    errors = np.stack([answer.predicted, answer.errors])
    before, after = prediction.common_variance(errors, answer.independent)[:, joint]
    return float(before), float(before - after)


def relative_change(before: np.ndarray, after: np.ndarray) -> tuple[float, float]:
    """Relative change of the sum of squared errors of blocks (k,), and its standard deviation over blocks."""
    count, total = len(after), max(float(before.sum()), 1e-300)
    ratio = float(after.sum()) / total
    scatter = float(np.sum((after - ratio * before) ** 2)) * count / max(count - 1, 1)
    return ratio - 1.0, float(np.sqrt(scatter)) / total
