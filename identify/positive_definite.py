"""Cholesky factors of normal matrices and covariances of any rank.

In exact arithmetic such a matrix has no negative eigenvalue. In a direction that the data do not determine,
rounding may make one, and a Cholesky factorization fails. The functions here return a factor nevertheless.
"""

from typing import NamedTuple

import numpy as np
from scipy import linalg
from scipy.linalg import lapack

from .errors import FitError

ROUNDING = 1e-12
"""Eigenvalues of a matrix with a unit diagonal that count as rounding errors are below this: a sum of some
thousand products has lost four of sixteen digits."""
NOTHING = 1e-30
"""Diagonal element below which a row counts as zero: the square of a femtometer or a femtonewton."""


class Factor(NamedTuple):
    """Factor of a matrix (n, n) whose rows and columns were multiplied by a scale."""

    triangle: np.ndarray  # R (n, n) with R^T R equal to the scaled matrix; ignore what is below the diagonal
    scale: np.ndarray  # one over the square root of the diagonal, shape (n,)


def factored(matrix: np.ndarray, ridge: float = 0.0) -> Factor:
    """Factor of a symmetric matrix (n, n) whose eigenvalues are not negative, except for rounding.

    Args:
        matrix: Normal matrix or covariance.
        ridge: Number added to the diagonal after scaling, so that undetermined unknowns become zero.

    Raises:
        FitError: The matrix is not finite.
    """
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), NOTHING))
    scaled = matrix * scale[:, None] * scale
    scaled[np.diag_indices_from(scaled)] += ridge
    # LAPACK is called directly: thousands of matrices are factored, and SciPy's checks take longer than that.
    triangle, failed = lapack.dpotrf(scaled, clean=0)
    # LAPACK does not report NaN; no comparison with NaN is true.
    if not failed and np.min(np.diagonal(triangle)) > np.sqrt(ROUNDING):
        return Factor(triangle, scale)
    return _singular(scaled, scale)


def solve(factor: Factor, right: np.ndarray) -> np.ndarray:
    """Solution for one right-hand side (n,) or several (n, m)."""
    triangle, scale = factor
    wide = scale if right.ndim == 1 else scale[:, None]
    return np.asarray(wide * lapack.dpotrs(triangle, wide * right)[0])


def root(matrix: np.ndarray) -> np.ndarray:
    """Lower triangle L (n, n) with L L^T equal to a matrix that `factored` accepts.

    Raises:
        FitError: The matrix is not finite.
    """
    factor = factored(matrix)
    return np.asarray(np.triu(factor.triangle).T / factor.scale[:, None])


def inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverse (n, n) of a matrix that `factored` accepts.

    Raises:
        FitError: The matrix is not finite.
    """
    return solve(factored(matrix), np.eye(len(matrix)))


def whitening(factor: Factor) -> np.ndarray:
    """Matrix W (n, n) that whitens unknowns with covariance M: W M W^T = 1."""
    inverse, _ = lapack.dtrtri(np.triu(factor.triangle))
    return np.asarray(inverse.T * factor.scale)


def spectrum(scaled: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues (n,) and eigenvectors (n, n) of a scaled matrix.

    Eigenvalues are raised to the level of rounding errors, which a negative eigenvalue reveals.

    Raises:
        FitError: The matrix is not finite.
    """
    if not np.all(np.isfinite(scaled)):
        count = np.count_nonzero(~np.isfinite(scaled))
        raise FitError(
            f"{count} of {scaled.size} elements of a covariance or normal matrix are not finite; the values, "
            "standard deviations or weights behind them are too large: check their units"
        )
    values, axes = np.linalg.eigh(scaled)
    least = max(ROUNDING, -2.0 * float(values[0]))
    return np.maximum(values, least), axes


def after_unit_prior(rows: np.ndarray) -> np.ndarray:
    """Posterior covariance (p, p) of unknowns with unit prior variance, given rows (b, p) with unit noise.

    This is the inverse of rows^T rows + 1, computed from singular values: beside rows of 1e8 the sum would
    lose the prior.

    Raises:
        FitError: The rows are not finite.
    """
    if not np.all(np.isfinite(rows)):
        raise FitError(
            "standard deviations of the fit are too small beside those of nominal values: check their units"
        )
    _, sizes, axes = linalg.svd(rows, full_matrices=True, lapack_driver="gesvd")
    std = np.ones(rows.shape[1])
    std[: len(sizes)] = 1.0 / np.hypot(1.0, sizes)
    spread = axes.T * std
    return spread @ spread.T


def _singular(scaled: np.ndarray, scale: np.ndarray) -> Factor:
    """Factor of a scaled matrix that is numerically not positive definite."""
    values, axes = np.full(len(scale), ROUNDING), np.eye(len(scale))
    nonzero = np.flatnonzero(np.any(scaled, axis=1))
    if nonzero.size:  # keeps rows of zeros exactly separate from the others
        place = np.ix_(nonzero, nonzero)
        values[nonzero], axes[place] = spectrum(scaled[place])
    triangle = np.asarray(np.linalg.qr((axes * np.sqrt(values)).T, mode="r"))
    signs = np.where(np.diag(triangle) < 0.0, -1.0, 1.0)
    return Factor(triangle * signs[:, None], scale)
