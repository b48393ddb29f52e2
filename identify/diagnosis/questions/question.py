"""Question: would the columns of a candidate have predicted the left-out blocks better?"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ..blocks.block_likelihood import strain, strains, trusted
from ..blocks.prediction import Prediction
from .block_answer import Answer, prior_std
from .candidate import Candidate, Thinned
from .candidate_fit import Fitted, fitted, solved, with_diagonal, within_limits
from .products import Products

TOGETHER = 48
"""Candidates that are evaluated at once: some tens of megabytes of products."""


def ask(
    prediction: Prediction, pairs: Iterable[tuple[Candidate, Thinned]], strange: bool = False
) -> list[Answer]:
    """Answers of candidates, from blocks that are each left out in turn; physics excludes some candidates.

    Args:
        prediction: Prediction without the candidates.
        pairs: Candidates and their columns.
        strange: Whether to include candidates that physics excludes only in this shape.
    """
    groups: dict[tuple[int, ...], list[tuple[Candidate, Thinned]]] = {}
    for pair in pairs:
        groups.setdefault((pair[1].values.shape[2], *pair[1].joints), []).append(pair)
    return [
        answer
        for alike in groups.values()
        for start in range(0, len(alike), TOGETHER)
        for answer in _answers(prediction, alike[start : start + TOGETHER])
        if strange or not answer.strange
    ]


def _answers(prediction: Prediction, alike: Sequence[tuple[Candidate, Thinned]]) -> list[Answer]:
    """Answers of candidates on the same joints with the same number of columns."""
    products = Products.of(prediction, [columns for _, columns in alike])
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
    """Change of every block's prediction by the others with an answer's effect, shape (r, n) [N m]."""
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


class _Eliminated(NamedTuple):
    """Normal equations of candidates, from which the unknowns of the prediction are eliminated."""

    whitened: np.ndarray  # products with the unknowns, whitened, shape (..., i, p, b)
    matrix: np.ndarray  # normal matrices of the coefficients, shape (..., i, p, p)
    right: np.ndarray  # right-hand sides, shape (..., i, p)

    @classmethod
    def of(
        cls, root: np.ndarray, mixed: np.ndarray, matrix: np.ndarray, right: np.ndarray, values: np.ndarray
    ) -> "_Eliminated":
        """Eliminate the unknowns, s of which act on the joints of the candidates.

        Args:
            root: Columns of the s unknowns in the root of the inverse normal matrix, shape (..., b, s).
            mixed: Products of candidates with the s unknowns, shape (..., i, p, s).
            matrix: Products of candidates with themselves, shape (..., i, p, p).
            right: Products of candidates with the torque, shape (..., i, p).
            values: Values of the s unknowns without candidates, shape (..., s).
        """
        flat = mixed.reshape(*right.shape[:-2], -1, mixed.shape[-1])
        whitened = (flat @ np.swapaxes(root, -1, -2)).reshape(*right.shape, -1)
        explained = (flat @ values[..., None]).reshape(right.shape)
        return cls(whitened, matrix - gram(whitened), right - explained)

    def decrease(self, root: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        """Decrease of unknowns (..., i, s) by coefficients (..., i, p), given the root's columns of these."""
        return combined(coefficients, self.whitened) @ root


def combined(coefficients: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Linear combinations (..., b) of rows (..., p, b); faster than matrix products for few rows."""
    return np.asarray(np.einsum("...p,...pb->...b", coefficients, rows))


def gram(rows: np.ndarray) -> np.ndarray:
    """Products of rows (..., p, b) with each other, shape (..., p, p)."""
    if rows.shape[-2] == 1:  # thousands of matrices of one element
        return np.einsum("...pb,...pb->...p", rows, rows)[..., None]
    return np.asarray(rows @ np.swapaxes(rows, -1, -2))


def _fitted(
    prediction: Prediction, products: Products, alike: Sequence[tuple[Candidate, Thinned]]
) -> tuple[Fitted, np.ndarray]:
    """Coefficients from all fitted blocks, and the gain of the priors with each candidate, shape (i,)."""
    mixed, root = products.mixed.sum(axis=0), prediction.root
    eliminated = _Eliminated.of(
        root[:, products.places], mixed, products.weighted.sum(axis=0), products.torque.sum(axis=0),
        prediction.values[products.places],
    )  # fmt: skip
    limited = eliminated.whitened @ root[:, prediction.rows.limited]
    fits = fitted(eliminated.matrix, eliminated.right, alike)
    fits = within_limits(prediction, limited, eliminated.matrix, alike, fits)
    # Information on the coefficients from priors of the model, beyond that from blocks.
    of_blocks = (mixed.reshape(-1, mixed.shape[2]) @ prediction.root_of_blocks[:, products.places].T).reshape(
        eliminated.whitened.shape
    )
    informed = gram(of_blocks) - gram(eliminated.whitened)
    change = eliminated.decrease(root, fits.values)
    candidates = [candidate for candidate, _ in alike]
    return fits, _relief(prediction, change, fits, candidates) - _optimism(eliminated.matrix, informed, fits)


def _cost(candidate: Candidate) -> float:
    """Log of the number of shapes; a coefficient with only one sign halves the possible values."""
    signs = sum(limit == 0.0 for limit in candidate.lower)
    return float(np.log(candidate.among) - np.log(2.0) * signs)


def _surprise(prediction: Prediction, errors: np.ndarray, candidate: Candidate, columns: Thinned) -> float:
    """Loss in log probability of an effect from the size of its torque, if its cause gives a size."""
    if np.isinf(candidate.size) or columns.usual is None:
        return 0.0
    explained = prediction.power(prediction.errors) - prediction.power(errors)
    torque = np.sqrt(np.maximum(explained[columns.joints], 0.0))
    return strain(np.max(torque / np.maximum(columns.usual, 1e-300)) / candidate.size)


def _relief(
    prediction: Prediction, change: np.ndarray, fits: Fitted, candidates: Sequence[Candidate]
) -> np.ndarray:
    """Gain in log probability of the priors with each candidate, its own expected size included, (i,).

    Args:
        prediction: Prediction without the candidates.
        change: Decrease of the unknowns with each candidate, shape (i, b).
        fits: Fitted coefficients.
        candidates: Candidates, i of them.
    """
    rows, values, known = prediction.rows, prediction.values, prediction.stated
    before, after = ((x - rows.mean)[..., known] / rows.std[known] for x in (values, values - change))
    expected = np.array([candidate.expected is not None for candidate in candidates])
    counted = fits.free & expected[:, None]
    deviations = np.where(counted, (fits.values - fits.mean) * np.sqrt(fits.precision), 0.0)
    bounded = rows.bounded[known]
    strain_after = strains(after, bounded).sum(axis=-1) + strains(deviations).sum(axis=-1)
    return np.asarray(strain(before, bounded) - strain_after)


def _optimism(matrix: np.ndarray, informed: np.ndarray, fits: Fitted) -> np.ndarray:
    """Effective number of coefficients that relieve the model's priors, for each candidate, shape (i,).

    Each of these lowers the strain of the priors by one even where no effect is missing: the optimism of a
    fit (Akaike).
    """
    free = fits.free[:, :, None] & fits.free[:, None, :]
    return np.trace(np.linalg.solve(fits.held(matrix), np.where(free, informed, 0.0)), axis1=1, axis2=2)


def _predicted(
    prediction: Prediction, products: Products, fits: Fitted
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of blocks (i, k, n), their residuals along each effect (i, k), and squared effects (i, k)."""
    sums, noise = prediction.sums, 1.0 / prediction.weighting.variance
    share = prediction.weighting.independent
    coefficients, change = _without(prediction, products, fits)
    errors = np.repeat(prediction.errors[:, None], len(fits.values), axis=1)
    along, size = np.zeros(errors.shape[:2]), np.zeros(errors.shape[:2])
    places = {int(joint): place for place, joint in enumerate(products.joints)}
    for joint, acting in enumerate(sums.acting):
        decrease = change[:, :, acting]
        linear = -(decrease @ prediction.slopes[joint][:, :, None])[..., 0]
        square = np.einsum("kia,kia->ki", decrease, decrease @ sums.gram[joint])
        if joint in places:
            place = places[joint]
            effect = combined(coefficients, products.parts[place])
            explained = effect @ prediction.left_out[:, acting, None]
            linear += np.einsum("kip,kip->ki", coefficients, products.by_torque[:, place]) - explained[..., 0]
            twice = combined(coefficients, products.gram[:, place])
            square += np.einsum("kip,kip->ki", twice, coefficients)
            square -= 2.0 * np.einsum("kia,kia->ki", effect, decrease)
        errors[:, :, joint] = np.maximum(errors[:, :, joint] - 2.0 * linear + square, 1e-12)
        # A block predicted from motions too unlike its own is down-weighted, as in a fit.
        rows = share[joint] * sums.counts[:, joint, None]
        weight = noise[joint] * trusted(share[joint] * noise[joint] * errors[:, :, joint], rows)
        along += weight * linear
        size += weight * square
    return errors.transpose(1, 0, 2), along.T, size.T


def _without(prediction: Prediction, products: Products, fits: Fitted) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients (k, i, p), and decrease of the unknowns (k, i, b), fitted without each block."""
    mixed, matrix, right = (
        blocks.sum(axis=0) - blocks for blocks in (products.mixed, products.weighted, products.torque)
    )
    places = products.places
    eliminated = _Eliminated.of(
        prediction.roots[:, :, places], mixed, matrix, right, prediction.left_out[:, places]
    )
    matrix = with_diagonal(eliminated.matrix, fits.precision)
    right = eliminated.right + fits.precision * fits.mean
    coefficients = solved(matrix, right, fits.values, fits.free)
    return coefficients, eliminated.decrease(prediction.roots, coefficients)
