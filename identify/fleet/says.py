"""Information of runs about an arm when each run deviates from the arm: small products, run by run."""

from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri


class Information(NamedTuple):
    """Information of each run about the arm's unknowns and changes, with the run's deviation integrated out.

    Attributes:
        inverse: Inverse of the unit matrix plus the run's normal matrix scaled by its variances, shape
            (r, m, m).
        normal: Normal matrix, shape (r, m, m).
        right: Right-hand side, shape (r, m).
        constant: Remaining part of the run's log-likelihood, shape (r,).
    """

    inverse: np.ndarray
    normal: np.ndarray
    right: np.ndarray
    constant: np.ndarray


def information(normal: np.ndarray, right: np.ndarray, variance: np.ndarray) -> Information:
    """Information by normal matrices (r, m, m), right-hand sides and variances of deviations (r, m)."""
    root, size = np.sqrt(variance), np.eye(variance.shape[1])
    inverse, logarithm = _inverse(size + root[:, :, None] * normal * root[:, None, :])
    scaled = np.einsum("rmn,rn->rm", inverse, root * right)
    constant = 0.5 * np.sum(root * right * scaled, axis=1) - 0.5 * logarithm
    normal = (size - inverse) / root[:, :, None] / root[:, None, :]
    return Information(inverse, normal, scaled / root, constant)


def _inverse(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inverses of matrices (r, m, m) with eigenvalues of one or more, and log-determinants (r,)."""
    work, logarithms = matrices.copy(), np.empty(len(matrices))
    for k, matrix in enumerate(work):  # LAPACK works in place; its lower triangle is the upper one of rows
        dpotrf(matrix.T, lower=1, clean=0, overwrite_a=1)
        logarithms[k] = 2.0 * np.sum(np.log(np.diagonal(matrix)))
        dpotri(matrix.T, lower=1, overwrite_c=1)
    return np.triu(work) + np.swapaxes(np.triu(work, 1), 1, 2), logarithms


class Sums(NamedTuple):
    """Normal equations of each run for the arm's unknowns, and for a further change of every unknown.

    Attributes:
        normal: Normal matrix of the arm's unknowns and the changes so far, shape (r, d, d).
        right: Right-hand side of these, shape (r, d).
        across: Products of these with a change of every unknown, shape (r, d, m).
        change_normal: Normal matrix of a change of every unknown, shape (r, m, m).
        change_right: Right-hand side of it, shape (r, m).
    """

    normal: np.ndarray
    right: np.ndarray
    across: np.ndarray
    change_normal: np.ndarray
    change_right: np.ndarray

    @classmethod
    def of(cls, info: Information, columns: np.ndarray, factor: np.ndarray) -> "Sums":
        """Sums for columns (r, m, d), and for changes of each unknown by a factor (r, m)."""
        transposed = np.swapaxes(columns, 1, 2)
        weighted = transposed @ info.normal
        return cls(
            weighted @ columns,
            np.einsum("rdm,rm->rd", transposed, info.right),
            weighted * factor[:, None, :],
            factor[:, :, None] * info.normal * factor[:, None, :],
            factor * info.right,
        )
