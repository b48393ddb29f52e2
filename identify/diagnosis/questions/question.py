"""Question: would the columns of a candidate have predicted the left-out blocks better?"""

from collections.abc import Iterable, Sequence

import numpy as np

from ..blocks.block_likelihood import strain, strains, trusted
from ..blocks.prediction import Prediction
from .block_answer import Answer, prior_std
from .candidate import Candidate, Thinned
from .candidate_fit import Fitted, fitted, within_limits
from .eliminated import Eliminated, gram

TOGETHER = 2e6
"""Numbers that the columns of candidates evaluated at once have: they stay in the processor's cache."""


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
    for candidate, columns in pairs:
        groups.setdefault((len(columns.mean), *columns.joints), []).append((candidate, columns))
    return [
        answer
        for (count, *_), alike in groups.items()
        for together in [max(1, int(TOGETHER / (count * prediction.rows.difference.size)))]
        for start in range(0, len(alike), together)
        for answer in _answers(prediction, alike[start : start + together])
        if strange or not answer.strange
    ]


def _answers(prediction: Prediction, alike: Sequence[tuple[Candidate, Thinned]]) -> list[Answer]:
    """Answers of candidates with as many columns on the same joints."""
    eliminated = Eliminated.of(prediction, [columns for _, columns in alike])
    fits, relief = _fitted(eliminated, alike)
    errors = np.tile(prediction.errors, (len(alike), 1, 1))
    along, size = np.zeros((2, *errors.shape[:2]))
    # Akaike's estimate of the gain in left-out blocks; without any, the blocks need not be left out in turn.
    expected = eliminated.gain(fits) - fits.free.sum(axis=1)
    chosen = np.flatnonzero(fits.possible & (expected > 0.0))
    if len(chosen):
        compared = eliminated.only(chosen).compared(fits.only(chosen))
        errors[chosen], along[chosen], size[chosen] = _compared(prediction, *compared)
    relief = np.where(expected > 0.0, relief, np.minimum(relief, 0.0))
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
    """Change of every block's prediction by the others with an answer's effect, shape (n, r) [N m].

    Rows are sorted by block, and zero where a row does not count.
    """
    candidate, columns = answer.candidate, answer.columns
    fits = Fitted(
        answer.values[None],
        answer.free[None],
        prior_std(candidate, columns)[None] ** -2.0,
        columns.mean[None],
        np.ones(1, bool),
    )
    return Eliminated.of(prediction, [columns]).predicted(fits, columns)


def _fitted(eliminated: Eliminated, alike: Sequence[tuple[Candidate, Thinned]]) -> tuple[Fitted, np.ndarray]:
    """Coefficients from all fitted blocks, and the gain of the priors with each candidate, shape (i,)."""
    prediction = eliminated.prediction
    limited = eliminated.whitened @ prediction.root[:, prediction.rows.limited]
    fits = fitted(eliminated.matrix, eliminated.right, alike)
    fits = within_limits(prediction, limited, eliminated.matrix, alike, fits)
    # Information on the coefficients from priors of the model, beyond that from blocks.
    informed = gram(eliminated.products @ prediction.root_of_blocks.T) - gram(eliminated.whitened)
    change = eliminated.decrease(fits.values)
    candidates = [candidate for candidate, _ in alike]
    return fits, _relief(prediction, change, fits, candidates) - _optimism(eliminated.matrix, informed, fits)


def _compared(
    prediction: Prediction, linear: np.ndarray, square: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of blocks (i, k, n), their residuals along each effect (i, k), and squared effects (i, k)."""
    noise, share = 1.0 / prediction.weighting.variance, prediction.weighting.independent
    linear, square = (np.swapaxes(product, 0, 1) / prediction.scale**2 for product in (linear, square))
    errors = np.maximum(prediction.errors - 2.0 * linear + square, 1e-12)
    # A block predicted from motions too unlike its own is down-weighted, as in a fit.
    weight = noise * trusted(share * noise * errors, share * prediction.sums.counts)
    return errors, (weight * linear).sum(axis=2), (weight * square).sum(axis=2)


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
    """Gain in log probability of the priors with each candidate, its own expected size included, (i,)."""
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
