"""Question: would candidate columns have predicted the blocks that were left out better?"""

from collections.abc import Iterable, Sequence

import numpy as np

from .block_answer import Answer
from .block_likelihood import strain, trusted
from .candidate import Candidate, Thinned
from .candidate_fit import Fitted, beside_limits, fitted, solved
from .prediction import CERTAIN, Prediction, solve
from .products import Products

TOGETHER = 48
"""Candidates that are asked for at once: some tens of megabytes of products."""


def ask(prediction: Prediction, asked: Iterable[tuple[Candidate, Thinned]]) -> list[Answer]:
    """Answers of all blocks, each left out in turn, without those that physics excludes."""
    by_joints: dict[tuple[int, ...], list[tuple[Candidate, Thinned]]] = {}
    for pair in asked:
        by_joints.setdefault(tuple(pair[1].joints), []).append(pair)
    return [
        answer
        for alike in by_joints.values()
        for start in range(0, len(alike), TOGETHER)
        for answer in _answers(prediction, alike[start : start + TOGETHER])
    ]


def _answers(prediction: Prediction, alike: Sequence[tuple[Candidate, Thinned]]) -> list[Answer]:
    products = Products.of(prediction, [columns for _, columns in alike])
    mixed = products.mixed.sum(axis=0)
    apart = solve(prediction.factor, mixed)
    matrix = products.weighted.sum(axis=0) - mixed.T @ apart
    right = products.torque.sum(axis=0) - mixed.T @ prediction.values
    fits = [
        beside_limits(
            prediction,
            apart[:, own],
            matrix[np.ix_(own, own)],
            columns,
            fitted(matrix[np.ix_(own, own)], right[own], candidate, columns),
        )
        for (candidate, columns), own in zip(alike, products.places, strict=True)
    ]
    errors, along, size = _predicted(prediction, products, fits)
    share = prediction.weighting.independent
    gains = prediction.log_probability(errors, share) - prediction.log_probability(prediction.errors, share)
    return [
        Answer(
            candidate, columns, one.values, one.free, prediction.errors, errors[i], along[i], size[i],
            gains[i], _cost(candidate), share,
            prediction.blocks.fitted,
            _relief(prediction, apart[:, products.places[i]], one, candidate)
            - _surprise(prediction, errors[i], candidate, columns),
        )
        for i, ((candidate, columns), one) in enumerate(zip(alike, fits, strict=True))
        if one is not None
    ]  # fmt: skip


def _cost(candidate: Candidate) -> float:
    """Logarithm of the number of shapes; with one sign only, half as many values may be."""
    signs = sum(limit == 0.0 for limit in candidate.lower)
    return float(np.log(candidate.among) - np.log(2.0) * signs)


def _surprise(prediction: Prediction, errors: np.ndarray, candidate: Candidate, columns: Thinned) -> float:
    """By how much less probable an effect is for its torque, where its cause says how large that is."""
    if np.isinf(candidate.size) or columns.usual is None:
        return 0.0
    explained = prediction.power(prediction.errors) - prediction.power(errors)
    torque = np.sqrt(np.maximum(explained[columns.joints], 0.0))
    return strain(np.max(torque / np.maximum(columns.usual, 1e-300)) / candidate.size)


def _relief(prediction: Prediction, apart: np.ndarray, one: Fitted, candidate: Candidate) -> float:
    """By how much more probable beliefs are beside a candidate, what physics expects of itself included."""
    rows, values = prediction.rows, prediction.values
    known = np.isfinite(rows.std) & (rows.std > CERTAIN)
    before, after = ((x - rows.mean)[known] / rows.std[known] for x in (values, values - apart @ one.values))
    own = np.zeros(0)
    if candidate.expected is not None:
        own = ((one.values - one.mean) * np.sqrt(one.precision))[one.free]
    return strain(before) - strain(after) - strain(own)


def _predicted(
    prediction: Prediction, products: Products, fitted: Sequence[Fitted | None]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of blocks (i, k, n), their residuals along each effect (i, k), and its squares (i, k)."""
    sums, noise = prediction.sums, 1.0 / prediction.weighting.variance
    errors = np.repeat(prediction.errors[None], len(fitted), axis=0)
    along, size = np.zeros(errors.shape[:2]), np.zeros(errors.shape[:2])
    whole, torque = products.mixed.sum(axis=0), products.torque.sum(axis=0)
    matrix, share = products.weighted.sum(axis=0), prediction.weighting.independent
    rows = share * sums.counts
    for block in range(errors.shape[1]):
        mixed, base = whole - products.mixed[block], prediction.left_out[block]
        apart = solve(prediction.factors[block], mixed)
        own = matrix - products.weighted[block] - mixed.T @ apart
        coefficients = _without(own, torque - products.torque[block] - mixed.T @ base, products, fitted)
        change = apart @ coefficients  # of the other unknowns, downwards
        for joint in range(errors.shape[2]):
            acting = sums.acting[joint]
            gram, moved, here = sums.gram[block][joint], change[acting], base[acting]
            linear = -moved.T @ (sums.right[block][joint] - gram @ here)
            square = np.sum(moved * (gram @ moved), axis=0)
            for place in np.flatnonzero(products.joints == joint):
                one, two = products.parts[block][place]
                linear += coefficients.T @ (two - one.T @ here)
                square += np.sum(
                    coefficients * (products.own[block, place] @ coefficients - 2.0 * one.T @ moved), axis=0
                )
            errors[:, block, joint] = np.maximum(errors[:, block, joint] - 2.0 * linear + square, 1e-12)
            # A block that was predicted from motions too unlike its own says as little of the effect.
            sound = trusted(share[joint] * noise[joint] * errors[:, block, joint], rows[block, joint])
            along[:, block] += sound * noise[joint] * linear
            size[:, block] += sound * noise[joint] * square
    return errors, along, size


def _without(
    matrix: np.ndarray, right: np.ndarray, products: Products, fitted: Sequence[Fitted | None]
) -> np.ndarray:
    """Coefficients of every candidate by the blocks that are not left out, in its own columns, (c, i)."""
    found = np.zeros((len(right), len(fitted)))
    for place, (own, one) in enumerate(zip(products.places, fitted, strict=True)):
        if one is None:
            continue
        values = np.where(one.free, 0.0, one.values)
        whole = matrix[np.ix_(own, own)] + np.diag(one.precision)
        values[one.free] = solved(whole, right[own] + one.precision * one.mean, values, one.free)
        found[own, place] = values
    return found
