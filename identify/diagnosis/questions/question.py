"""Question: would candidate columns have predicted the blocks that were left out better?"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ..blocks.block_likelihood import strain, strains, trusted
from ..blocks.prediction import Prediction
from .block_answer import Answer, prior_std
from .candidate import Candidate, Thinned
from .candidate_fit import Fitted, beside_limits, fitted, solved, with_diagonal
from .products import Products

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
    every = [columns for _, columns in alike]
    products = Products.of(prediction, every)
    fits, relief = _fitted(prediction, products, alike)
    errors, along, size = _predicted(prediction, products, fits)
    share = prediction.weighting.independent
    gains = prediction.log_probability(errors, share) - prediction.log_probability_now
    return [
        Answer(
            candidate, columns, fits.values[i], fits.free[i], prediction.errors, errors[i], along[i], size[i],
            gains[i], share, prediction.blocks.fitted, _cost(candidate),
            relief[i] - _surprise(prediction, errors[i], candidate, columns),
        )
        for i, (candidate, columns) in enumerate(alike)
        if fits.possible[i]
    ]  # fmt: skip


def predicted_change(prediction: Prediction, answer: Answer) -> np.ndarray:
    """By how much an answer changes what the others predict of every block, shape (r, n) [N m]."""
    candidate, columns = answer.candidate, answer.columns
    fits = Fitted(
        answer.values[None],
        answer.free[None],
        prior_std(candidate, columns)[None] ** -2.0,
        columns.mean[None],
        np.ones(1, bool),
    )
    coefficients, change = _without(prediction, Products.of(prediction, [columns]), fits)
    torque = np.zeros(prediction.rows.difference.shape)
    for place, rows in enumerate(prediction.blocks.rows):
        torque[rows] = -prediction.rows.columns[rows] @ change[place, 0]
        torque[rows.start : rows.stop, columns.joints] += columns.values[rows] @ coefficients[place, 0]
    return torque


class _Apart(NamedTuple):
    """Candidates beside the prediction's unknowns, which are solved for anew."""

    whitened: np.ndarray  # products with the unknowns, whitened, shape (..., i, p, b)
    matrix: np.ndarray  # normal matrices of the coefficients, shape (..., i, p, p)
    right: np.ndarray  # right-hand sides, shape (..., i, p)

    @classmethod
    def of(
        cls, root: np.ndarray, mixed: np.ndarray, matrix: np.ndarray, right: np.ndarray, values: np.ndarray
    ) -> "_Apart":
        """By products with s of the unknowns.

        Args:
            root: Those s columns of the root of the inverse normal matrix of the unknowns, (..., b, s).
            mixed: Products of candidates with those unknowns, shape (..., i, p, s).
            matrix: Products of candidates with themselves, shape (..., i, p, p).
            right: Products of candidates with the torque, shape (..., i, p).
            values: Those unknowns without candidates, shape (..., s).
        """
        flat = mixed.reshape(*right.shape[:-2], -1, mixed.shape[-1])
        whitened = (flat @ np.swapaxes(root, -1, -2)).reshape(*right.shape, -1)
        explained = (flat @ values[..., None]).reshape(right.shape)
        return cls(whitened, matrix - gram(whitened), right - explained)

    def unwhitened(self, root: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        """By how much coefficients (..., i, p) lower the unknowns, (..., i, s), by the root of those."""
        return combined(coefficients, self.whitened) @ root


def combined(coefficients: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Sums (..., b) of rows (..., p, b) with coefficients (..., p), faster than by matrix products."""
    return np.asarray(np.einsum("...p,...pb->...b", coefficients, rows))


def gram(rows: np.ndarray) -> np.ndarray:
    """Products of rows (..., p, b) with each other, shape (..., p, p)."""
    if rows.shape[-2] == 1:  # thousands of matrices of one element
        return np.einsum("...pb,...pb->...p", rows, rows)[..., None]
    return np.asarray(rows @ np.swapaxes(rows, -1, -2))


def _fitted(
    prediction: Prediction, products: Products, alike: Sequence[tuple[Candidate, Thinned]]
) -> tuple[Fitted, np.ndarray]:
    """Coefficients by all fitted blocks, and by how much more probable priors are beside each, shape (i,)."""
    mixed, root = products.mixed.sum(axis=0), prediction.root
    apart = _Apart.of(
        root[:, products.places], mixed, products.weighted.sum(axis=0), products.torque.sum(axis=0),
        prediction.values[products.places],
    )  # fmt: skip
    limited = apart.whitened @ root[:, prediction.rows.limited]
    fits = fitted(apart.matrix, apart.right, alike)
    fits = beside_limits(prediction, limited, apart.matrix, [columns for _, columns in alike], fits)
    # What priors of the model say of the coefficients, beyond what blocks do.
    of_blocks = (mixed.reshape(-1, mixed.shape[2]) @ prediction.root_of_blocks[:, products.places].T).reshape(
        apart.whitened.shape
    )
    informed = gram(of_blocks) - gram(apart.whitened)
    change = apart.unwhitened(root, fits.values)
    candidates = [candidate for candidate, _ in alike]
    return fits, _relief(prediction, change, fits, candidates) - _freed(apart.matrix, informed, fits)


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


def _relief(
    prediction: Prediction, change: np.ndarray, fits: Fitted, candidates: Sequence[Candidate]
) -> np.ndarray:
    """By how much more probable priors are beside candidates, what physics expects of them included, (i,).

    Unknowns are less beside each candidate by a change (i, b).
    """
    rows, values, known = prediction.rows, prediction.values, prediction.stated
    before, after = ((x - rows.mean)[..., known] / rows.std[known] for x in (values, values - change))
    expected = np.array([candidate.expected is not None for candidate in candidates])
    counted = fits.free & expected[:, None]
    own = np.where(counted, (fits.values - fits.mean) * np.sqrt(fits.precision), 0.0)
    bounded = rows.bounded[known]
    less = strains(after, bounded).sum(axis=-1) + strains(own).sum(axis=-1)
    return np.asarray(strain(before, bounded) - less)


def _freed(matrix: np.ndarray, informed: np.ndarray, fits: Fitted) -> np.ndarray:
    """How many directions of the model's unknowns each candidate takes from their priors, shape (i,).

    So many free coefficients fit priors better than they predict, by one each, even where nothing is missing:
    the optimism of a fit (Akaike).
    """
    free = fits.free[:, :, None] & fits.free[:, None, :]
    return np.trace(np.linalg.solve(fits.held(matrix), np.where(free, informed, 0.0)), axis1=1, axis2=2)


def _predicted(
    prediction: Prediction, products: Products, fits: Fitted
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of blocks (i, k, n), their residuals along each effect (i, k), and its squares (i, k)."""
    sums, noise = prediction.sums, 1.0 / prediction.weighting.variance
    share = prediction.weighting.independent
    coefficients, change = _without(prediction, products, fits)
    errors = np.repeat(prediction.errors[:, None], len(fits.values), axis=1)
    along, size = np.zeros(errors.shape[:2]), np.zeros(errors.shape[:2])
    places = {int(joint): place for place, joint in enumerate(products.joints)}
    for joint, acting in enumerate(sums.acting):
        moved = change[:, :, acting]
        linear = -(moved @ prediction.slopes[joint][:, :, None])[..., 0]
        square = np.einsum("kia,kia->ki", moved, moved @ sums.gram[joint])
        if joint in places:
            place = places[joint]
            own = combined(coefficients, products.parts[place])
            explained = own @ prediction.left_out[:, acting, None]
            linear += np.einsum("kip,kip->ki", coefficients, products.by_torque[:, place]) - explained[..., 0]
            twice = combined(coefficients, products.own[:, place])
            square += np.einsum("kip,kip->ki", twice, coefficients)
            square -= 2.0 * np.einsum("kia,kia->ki", own, moved)
        errors[:, :, joint] = np.maximum(errors[:, :, joint] - 2.0 * linear + square, 1e-12)
        # A block that was predicted from motions too unlike its own shows as little of the effect.
        rows = share[joint] * sums.counts[:, joint, None]
        sound = noise[joint] * trusted(share[joint] * noise[joint] * errors[:, :, joint], rows)
        along += sound * linear
        size += sound * square
    return errors.transpose(1, 0, 2), along.T, size.T


def _without(prediction: Prediction, products: Products, fits: Fitted) -> tuple[np.ndarray, np.ndarray]:
    """By the other blocks: coefficients (k, i, p), and by how much less the unknowns are, (k, i, b)."""
    mixed, matrix, right = (
        one.sum(axis=0) - one for one in (products.mixed, products.weighted, products.torque)
    )
    places = products.places
    apart = _Apart.of(prediction.roots[:, :, places], mixed, matrix, right, prediction.left_out[:, places])
    whole = with_diagonal(apart.matrix, fits.precision)
    beside = apart.right + fits.precision * fits.mean
    found = solved(whole, beside, fits.values, fits.free)
    return found, apart.unwhitened(prediction.roots, found)
