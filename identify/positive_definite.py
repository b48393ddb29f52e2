"""Factors of symmetric matrices made from data: normal matrices and covariances, whatever their rank.

In exact arithmetic such a matrix has no negative eigenvalue. Rounding gives it some where the data do not
determine a direction, and then Cholesky's method ends in an error. Here it ends in a factor all the same,
which says which directions are not determined.
"""

from typing import NamedTuple

import numpy as np
from scipy import linalg
from scipy.linalg import lapack

from .errors import FitError

ROUNDING = 1e-12
"""Eigenvalue of a matrix with a unit diagonal below which it is rounding: a sum of some thousand products has
lost four of sixteen digits."""
NOTHING = 1e-30
"""Element on the diagonal below which a row is zero: the square of a femtometre or a femtonewton."""


class Factor(NamedTuple):
    """A factor of a matrix (n, n) whose rows and columns were multiplied by a scale.

    Attributes:
        triangle: Upper triangle R (n, n), the scaled matrix being R^T R; what is below it means nothing.
        scale: One over the root of the diagonal, shape (n,).
        undetermined: Unit vectors of the scaled unknowns of which the matrix shows nothing but rounding, as
            columns, shape (n, k); their eigenvalue was raised to what stands out of rounding.
    """

    triangle: np.ndarray
    scale: np.ndarray
    undetermined: np.ndarray


def factored(matrix: np.ndarray, ridge: float = 0.0) -> Factor:
    """Factor of a symmetric matrix (n, n) without negative eigenvalues, but for rounding.

    Args:
        matrix: Normal matrix or covariance.
        ridge: Added to the diagonal after scaling, so that unknowns that no row determines come out as zero.

    Raises:
        FitError: It is not finite.
    """
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), NOTHING))
    scaled = matrix * scale[:, None] * scale
    scaled[np.diag_indices_from(scaled)] += ridge
    # LAPACK itself: thousands of matrices are factored, and what SciPy adds takes as long as many of them.
    triangle, failed = lapack.dpotrf(scaled, clean=0)
    # LAPACK lets NaN pass, which is not above anything.
    if not failed and np.min(np.diagonal(triangle)) > np.sqrt(ROUNDING):
        return Factor(triangle, scale, np.zeros((len(scale), 0)))
    return _singular(scaled, scale)


def solve(factor: Factor, right: np.ndarray) -> np.ndarray:
    """Solution for one right-hand side (n,) or several (n, m)."""
    triangle, scale, _ = factor
    wide = scale if right.ndim == 1 else scale[:, None]
    return np.asarray(wide * lapack.dpotrs(triangle, wide * right)[0])


def root(matrix: np.ndarray) -> np.ndarray:
    """Lower triangle L (n, n) of a matrix as of `factored`, which is L L^T.

    Raises:
        FitError: It is not finite.
    """
    factor = factored(matrix)
    return np.asarray(np.triu(factor.triangle).T / factor.scale[:, None])


def inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverse (n, n) of a matrix as of `factored`.

    Raises:
        FitError: It is not finite.
    """
    return solve(factored(matrix), np.eye(len(matrix)))


def covariance(factor: Factor) -> np.ndarray:
    """Inverse of a normal matrix, shape (n, n); variances of undetermined unknowns are infinite."""
    whole = solve(factor, np.eye(len(factor.scale)))
    whole = 0.5 * (whole + whole.T)
    unknown = np.any(np.square(factor.undetermined) > ROUNDING, axis=1)
    whole[unknown, unknown] = np.inf
    return whole


def whitening(factor: Factor) -> np.ndarray:
    """Rows W (n, n) that make unknowns of this covariance M independent, of deviation one: W M W^T = 1."""
    inverse, _ = lapack.dtrtri(np.triu(factor.triangle))
    return np.asarray(inverse.T * factor.scale)


def spectrum(scaled: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eigenvalues (n,) above rounding, eigenvectors (n, n), and which were rounding (n,), of a scaled matrix.

    An eigenvalue below zero shows up to which size the others are rounding.

    Raises:
        FitError: It is not finite.
    """
    if not np.all(np.isfinite(scaled)):
        count = np.count_nonzero(~np.isfinite(scaled))
        raise FitError(
            f"{count} of {scaled.size} numbers of a covariance or of equations are not finite; values, "
            "deviations or weights behind them are too large: check their units"
        )
    values, axes = np.linalg.eigh(scaled)
    least = max(ROUNDING, -2.0 * float(values[0]))
    return np.maximum(values, least), axes, values < least


def after_unit_prior(rows: np.ndarray) -> np.ndarray:
    """Covariance (p, p) of unknowns of unit prior variance after rows (b, p) of unit noise.

    The inverse of rows^T rows + 1, by singular values: the sum would lose the prior beside rows of 1e8.

    Raises:
        FitError: They are not finite.
    """
    if not np.all(np.isfinite(rows)):
        raise FitError(
            "deviations of the fit are too small beside those of nominal values: check their units"
        )
    _, sizes, axes = linalg.svd(rows, full_matrices=True, lapack_driver="gesvd")
    left = np.ones(rows.shape[1])
    left[: len(sizes)] = 1.0 / np.hypot(1.0, sizes)
    spread = axes.T * left
    return spread @ spread.T


def _singular(scaled: np.ndarray, scale: np.ndarray) -> Factor:
    """Factor of a scaled matrix that is not positive definite to the last digits."""
    values, axes = np.full(len(scale), ROUNDING), np.eye(len(scale))
    rounding, shown = np.ones(len(scale), bool), np.flatnonzero(np.any(scaled, axis=1))
    if shown.size:  # rows of zeros stay apart from the others to the last digit
        place = np.ix_(shown, shown)
        values[shown], axes[place], rounding[shown] = spectrum(scaled[place])
    triangle = np.asarray(np.linalg.qr((axes * np.sqrt(values)).T, mode="r"))
    signs = np.where(np.diag(triangle) < 0.0, -1.0, 1.0)
    return Factor(triangle * signs[:, None], scale, axes[:, rounding])
