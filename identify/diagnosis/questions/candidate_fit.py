"""Candidate fit: coefficients of candidates from all fitted blocks, within physical limits."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..blocks.prediction import Prediction, rms_torque
from .block_answer import STRANGE, prior_std
from .candidate import Candidate, Thinned

FORMULA = 0.1
"""Error of formulas for friction and gears, share of their torque [-]: none is better than a tenth."""
SLIDING = 0.9
"""Share of its full column from which on dry friction has its full size [-]."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """Coefficients of i candidates, p each, fitted to all fitted blocks, and their priors."""

    values: np.ndarray  # coefficients, shape (i, p); zero where the effect is impossible
    free: np.ndarray  # whether each is within its limit, (i, p); False where the effect is impossible
    precision: np.ndarray  # inverse prior variance, shape (i, p)
    mean: np.ndarray  # prior mean, shape (i, p)
    possible: np.ndarray  # whether physics allows the candidate, shape (i,)

    def only(self, chosen: np.ndarray) -> "Fitted":
        """The chosen candidates alone, by index."""
        arrays = (self.values, self.free, self.precision, self.mean, self.possible)
        return Fitted(*(array[chosen] for array in arrays))

    def possible_where(self, possible: np.ndarray) -> "Fitted":
        """A copy in which only the marked candidates (i,) remain possible."""
        here = possible[:, None]
        return replace(
            self,
            values=np.where(here, self.values, 0.0),
            free=self.free & here,
            possible=self.possible & possible,
        )

    def held(self, matrix: np.ndarray) -> np.ndarray:
        """Normal matrices (i, p, p) of free coefficients with priors; identity for held coefficients."""
        free = self.free[:, :, None] & self.free[:, None, :]
        return np.where(free, with_diagonal(matrix, self.precision), np.eye(self.free.shape[1]))


def fitted(matrix: np.ndarray, right: np.ndarray, alike: Sequence[tuple[Candidate, Thinned]]) -> Fitted:
    """Fit the coefficients of candidates, held at their physical limits.

    Args:
        matrix: Normal matrices of their coefficients, all other unknowns eliminated, shape (i, p, p).
        right: Right-hand sides, shape (i, p).
        alike: Candidates and their columns, p each.
    """
    mean = np.array([columns.mean for _, columns in alike])
    precision = np.array([prior_std(*pair) for pair in alike]) ** -2.0
    lower = np.array([candidate.lower for candidate, _ in alike])
    matrix, right = with_diagonal(matrix, precision), right + precision * mean
    free, values = np.ones(lower.shape, bool), np.zeros(lower.shape)
    for _ in range(lower.shape[1] + 1):
        values = solved(matrix, right, values, free)
        below = free & (values < lower)
        if not np.any(below):
            break
        free &= ~below
        values[below] = lower[below]
    led = np.array(
        [
            candidate.led > 0 and not np.any(is_free[: candidate.led])
            for (candidate, _), is_free in zip(alike, free, strict=True)
        ]
    )
    possible = ~led & np.any(free, axis=1) & np.all(np.isfinite(values), axis=1)
    fits = Fitted(values, free, precision, mean, np.ones(len(alike), bool))
    return fits.possible_where(possible)


def within_limits(
    prediction: Prediction,
    decrease: np.ndarray,
    matrix: np.ndarray,
    alike: Sequence[tuple[Candidate, Thinned]],
    fits: Fitted,
) -> Fitted:
    """Exclude candidates that push another unknown beyond its physical limit.

    A friction effect that requires negative viscous friction is not that effect. A violation by a tenth of
    its own torque is allowed, since no formula is better.

    Args:
        prediction: Prediction without the candidates.
        decrease: Decrease of the limited unknowns per unit of each coefficient, (i, p, l).
        matrix: Normal matrices of the coefficients, all other unknowns eliminated, shape (i, p, p).
        alike: Candidates and their columns.
        fits: Fitted coefficients.
    """
    places = prediction.rows.limited
    if not len(places):
        return fits
    lower, before = prediction.rows.lower[places], prediction.values[places]
    after = before - np.einsum("ipl,ip->il", decrease, fits.values)
    free_decrease = np.where(fits.free[:, :, None], decrease, 0.0)
    variance = np.sum(free_decrease * np.linalg.solve(fits.held(matrix), free_decrease), axis=1)
    std = np.sqrt(prediction.limited_std**2 + np.maximum(variance, 0.0))
    below = np.minimum(lower, before) - STRANGE * std - after
    possible = np.ones(len(alike), bool)
    for number in np.flatnonzero(fits.possible & np.any(below > 0.0, axis=1)).tolist():
        torque = float(rms_torque((alike[number][1].values @ fits.values[number])[:, :, None])[0])
        tolerance = FORMULA * torque / np.maximum(prediction.limited_size, 1e-300)
        possible[number] = not np.any(below[number] > tolerance)
    for number, (candidate, _) in enumerate(alike):
        if candidate.varies and fits.possible[number]:
            most = dict(zip(places.tolist(), after[number] + STRANGE * std[number], strict=True))
            possible[number] &= not _pushes(prediction, *alike[number], fits.values[number], most)
    return fits.possible_where(possible)


def _pushes(
    prediction: Prediction,
    candidate: Candidate,
    columns: Thinned,
    coefficients: np.ndarray,
    most: Mapping[int, float],
) -> bool:
    """Whether a variation of dry friction exceeds it, for the largest credible values of limited unknowns."""
    rows, [joint] = prediction.rows, candidate.joints
    places = [place for place in most if rows.names[place] in candidate.varies]
    if not places or rows.names[places[0]] != candidate.varies[0]:
        return False  # the model has no dry friction here that could be less
    sign, torque = (
        rows.columns_at(np.array(places[:1]))[:, joint, 0],
        columns.values[:, columns.joints == joint],
    )
    slides = np.abs(sign) > SLIDING * np.max(np.abs(sign), initial=0.0)
    lowest = np.min((torque[:, 0] @ coefficients)[slides] / sign[slides], initial=0.0)
    return bool(sum(most[place] for place in places) - rows.lower[places[0]] < (FORMULA - 1.0) * lowest)


def solved(matrix: np.ndarray, right: np.ndarray, values: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Solve systems (..., p, p), (..., p) for the free unknowns; the others keep their values (..., p)."""
    held, identity = np.where(free, 0.0, values), np.eye(matrix.shape[-1])
    right = np.where(free, right - (matrix @ held[..., None])[..., 0], 0.0)
    size = np.sqrt(np.maximum(np.diagonal(matrix, axis1=-2, axis2=-1), 1e-300))
    scaled = np.where(
        free[..., :, None] & free[..., None, :],
        matrix / (size[..., :, None] * size[..., None, :]),
        identity,
    )
    scaled = scaled + 1e-10 * identity
    return np.where(free, np.linalg.solve(scaled, (right / size)[..., None])[..., 0] / size, held)


def with_diagonal(matrix: np.ndarray, more: np.ndarray) -> np.ndarray:
    """Matrices (..., p, p) with `more` (..., p) added to their diagonals."""
    total = matrix.copy()
    diagonal = np.einsum("...pp->...p", total)  # a view
    diagonal += more
    return total
