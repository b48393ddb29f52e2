"""Question: would candidate columns have predicted the blocks that were left out better?"""

from collections.abc import Iterable, Sequence

import numpy as np

from ...positive_definite import Factor, solve
from ..blocks.block_likelihood import strain, trusted
from ..blocks.prediction import Prediction
from .block_answer import Answer, prior_std
from .candidate import Candidate, Thinned
from .candidate_fit import Fitted, Products, beside_limits, fitted, solved

TOGETHER = 48
"""Candidates that are asked for at once: some tens of megabytes of products."""


def ask(
    prediction: Prediction, asked: Iterable[tuple[Candidate, Thinned]], strange: bool = False
) -> list[Answer]:
    """Answers of all blocks, each left out in turn, without those that physics excludes.

    With `strange`, those are included that physics excludes only in this shape.
    """
    groups: dict[tuple[int, ...], list[tuple[Candidate, Thinned]]] = {}
    for pair in asked:
        groups.setdefault((pair[1].values.shape[2], *pair[1].joints), []).append(pair)
    return [
        answer
        for alike in groups.values()
        for start in range(0, len(alike), TOGETHER)
        for answer in _answers(prediction, alike[start : start + TOGETHER])
        if strange or not answer.strange
    ]


def _answers(prediction: Prediction, alike: Sequence[tuple[Candidate, Thinned]]) -> list[Answer]:
    """Answers of candidates on the same joints and with as many columns each."""
    products = Products.of(prediction, [columns for _, columns in alike])
    mixed = products.mixed.sum(axis=0)
    apart = _solved(prediction.factor, mixed)
    matrix = products.weighted.sum(axis=0) - np.einsum("bip,biq->ipq", mixed, apart)
    right = products.torque.sum(axis=0) - np.einsum("bip,b->ip", mixed, prediction.values)
    fits = [
        beside_limits(
            prediction, apart[:, i], matrix[i], columns, fitted(matrix[i], right[i], candidate, columns)
        )
        for i, (candidate, columns) in enumerate(alike)
    ]
    # What priors of the model say of the coefficients, beyond what blocks do.
    informed = np.einsum("bip,biq->ipq", mixed, _solved(prediction.factor_of_blocks, mixed) - apart)
    errors, along, size = _predicted(prediction, products, fits)
    share = prediction.weighting.independent
    gains = prediction.log_probability(errors, share) - prediction.log_probability(prediction.errors, share)
    return [
        Answer(
            candidate, columns, one.values, one.free, prediction.errors, errors[i], along[i], size[i],
            gains[i], share, prediction.blocks.fitted, _cost(candidate),
            _relief(prediction, apart[:, i], one, candidate)
            - _freed(matrix[i], informed[i], one)
            - _surprise(prediction, errors[i], candidate, columns),
        )
        for i, ((candidate, columns), one) in enumerate(zip(alike, fits, strict=True))
        if one is not None
    ]  # fmt: skip


def predicted_change(prediction: Prediction, answer: Answer) -> np.ndarray:
    """By how much an answer changes what the others predict of every block, shape (r, n) [N m]."""
    one = Fitted(
        answer.values, answer.free, prior_std(answer.candidate, answer.columns) ** -2.0, answer.columns.mean
    )
    coefficients, change = _without(prediction, Products.of(prediction, [answer.columns]), [one])
    torque = np.zeros(prediction.rows.difference.shape)
    for place, rows in enumerate(prediction.blocks.rows):
        torque[rows] = -prediction.rows.columns[rows] @ change[place, :, 0]
        torque[rows.start : rows.stop, answer.columns.joints] += (
            answer.columns.values[rows] @ coefficients[place, 0]
        )
    return torque


def _solved(factor: Factor, right: np.ndarray) -> np.ndarray:
    """Solutions for right-hand sides (b, i, p)."""
    return solve(factor, right.reshape(len(right), -1)).reshape(right.shape)


def _cost(candidate: Candidate) -> float:
    """Logarithm of the number of shapes; with one sign only, half as many values may be."""
    signs = sum(limit == 0.0 for limit in candidate.lower)
    return float(np.log(candidate.among) - np.log(2.0) * signs)


def _surprise(prediction: Prediction, errors: np.ndarray, candidate: Candidate, columns: Thinned) -> float:
    """By how much less probable an effect is for its torque, where its cause gives its size."""
    if np.isinf(candidate.size) or columns.usual is None:
        return 0.0
    explained = prediction.power(prediction.errors) - prediction.power(errors)
    torque = np.sqrt(np.maximum(explained[columns.joints], 0.0))
    return strain(np.max(torque / np.maximum(columns.usual, 1e-300)) / candidate.size)


def _relief(prediction: Prediction, apart: np.ndarray, one: Fitted, candidate: Candidate) -> float:
    """By how much more probable priors are beside a candidate, what physics expects of itself included."""
    rows, values, known = prediction.rows, prediction.values, prediction.stated
    before, after = ((x - rows.mean)[known] / rows.std[known] for x in (values, values - apart @ one.values))
    own = np.zeros(0)
    if candidate.expected is not None:
        own = ((one.values - one.mean) * np.sqrt(one.precision))[one.free]
    bounded = rows.bounded[known]
    return strain(before, bounded) - strain(after, bounded) - strain(own)


def _freed(matrix: np.ndarray, informed: np.ndarray, one: Fitted) -> float:
    """How many directions of the model's unknowns a candidate takes from their priors.

    So many free coefficients fit priors better than they predict, by one each, even where nothing is missing:
    the optimism of a fit (Akaike).
    """
    free = np.ix_(one.free, one.free)
    held = (matrix + np.diag(one.precision))[free]
    return float(np.trace(np.linalg.solve(held, informed[free])))


def _predicted(
    prediction: Prediction, products: Products, fits: Sequence[Fitted | None]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of blocks (i, k, n), their residuals along each effect (i, k), and its squares (i, k)."""
    sums, noise = prediction.sums, 1.0 / prediction.weighting.variance
    share = prediction.weighting.independent
    coefficients, change = _without(prediction, products, fits)
    errors = np.repeat(prediction.errors[:, None], len(fits), axis=1)
    along, size = np.zeros(errors.shape[:2]), np.zeros(errors.shape[:2])
    places = {int(joint): place for place, joint in enumerate(products.joints)}
    for joint, acting in enumerate(sums.acting):
        moved = change[:, acting]
        linear = -np.einsum("kai,ka->ki", moved, prediction.slopes[joint])
        square = np.sum(moved * (sums.gram[joint] @ moved), axis=1)
        if joint in places:
            by_columns, own = products.parts[places[joint]], products.own[:, places[joint]]
            here = prediction.left_out[:, acting]
            left = products.by_torque[:, places[joint]] - np.einsum("kaip,ka->kip", by_columns, here)
            linear += np.sum(coefficients * left, axis=2)
            square += np.einsum("kip,kipq,kiq->ki", coefficients, own, coefficients, optimize=True)
            square -= 2.0 * np.einsum("kip,kaip,kai->ki", coefficients, by_columns, moved, optimize=True)
        errors[:, :, joint] = np.maximum(errors[:, :, joint] - 2.0 * linear + square, 1e-12)
        # A block that was predicted from motions too unlike its own shows as little of the effect.
        rows = share[joint] * sums.counts[:, joint, None]
        sound = noise[joint] * trusted(share[joint] * noise[joint] * errors[:, :, joint], rows)
        along += sound * linear
        size += sound * square
    return errors.transpose(1, 0, 2), along.T, size.T


def _without(
    prediction: Prediction, products: Products, fits: Sequence[Fitted | None]
) -> tuple[np.ndarray, np.ndarray]:
    """By the other blocks: coefficients (k, i, p), and by how much less the unknowns are, (k, b, i)."""
    mixed = products.mixed.sum(axis=0) - products.mixed
    apart = np.stack([_solved(one, own) for one, own in zip(prediction.factors, mixed, strict=True)])
    matrix = products.weighted.sum(axis=0) - products.weighted
    matrix -= np.einsum("kbip,kbiq->kipq", mixed, apart, optimize=True)
    right = products.torque.sum(axis=0) - products.torque
    right -= np.einsum("kbip,kb->kip", mixed, prediction.left_out)
    found = np.zeros(right.shape)
    for place, one in enumerate(fits):
        if one is not None:
            whole = matrix[:, place] + np.diag(one.precision)
            beside = right[:, place] + one.precision * one.mean
            found[:, place] = solved(whole, beside, one.values, one.free)
    return found, np.einsum("kbip,kip->kbi", apart, found)
