"""What runs say of an arm when each has a deviation of its own: sums of small products, run by run."""

from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri


class Says(NamedTuple):
    """What each run says of the arm's unknowns and changes, its own deviation allowed for.

    Attributes:
        inverse: Of the unit matrix and the run's normal matrix over its variances, shape (r, m, m).
        normal: Shape (r, m, m), and
        right: shape (r, m).
        constant: Logarithm of the run's probability but for these, shape (r,).
    """

    inverse: np.ndarray
    normal: np.ndarray
    right: np.ndarray
    constant: np.ndarray


def says(normal: np.ndarray, right: np.ndarray, variance: np.ndarray) -> Says:
    """By normal matrices (r, m, m), right-hand sides and variances of runs' own deviations (r, m)."""
    root, size = np.sqrt(variance), np.eye(variance.shape[1])
    inverse, logarithm = _inverse(size + root[:, :, None] * normal * root[:, None, :])
    scaled = np.einsum("rmn,rn->rm", inverse, root * right)
    constant = 0.5 * np.sum(root * right * scaled, axis=1) - 0.5 * logarithm
    return Says(inverse, (size - inverse) / root[:, :, None] / root[:, None, :], scaled / root, constant)


def _inverse(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inverses of matrices (r, m, m) without eigenvalues below one, and logarithms of determinants (r,)."""
    work, logarithms = matrices.copy(), np.empty(len(matrices))
    for k, one in enumerate(work):  # LAPACK works in place: its lower triangle is the upper one of rows
        dpotrf(one.T, lower=1, clean=0, overwrite_a=1)
        logarithms[k] = 2.0 * np.sum(np.log(np.diagonal(one)))
        dpotri(one.T, lower=1, overwrite_c=1)
    return np.triu(work) + np.swapaxes(np.triu(work, 1), 1, 2), logarithms


class Sums(NamedTuple):
    """Each run's products with the arm's columns, with a change of every unknown, and of both.

    Attributes:
        normal: Shape (r, d, d), and
        right: shape (r, d), of the arm's unknowns and the changes so far.
        across: Of these with a change of every unknown, shape (r, d, m).
        own: Of changes with each other, shape (r, m, m), and
        side: shape (r, m).
    """

    normal: np.ndarray
    right: np.ndarray
    across: np.ndarray
    own: np.ndarray
    side: np.ndarray

    @classmethod
    def of(cls, said: Says, columns: np.ndarray, factor: np.ndarray) -> "Sums":
        """For columns (r, m, d), and changes of each unknown by a factor (r, m)."""
        turned = np.swapaxes(columns, 1, 2)
        weighted = turned @ said.normal
        return cls(
            weighted @ columns,
            np.einsum("rdm,rm->rd", turned, said.right),
            weighted * factor[:, None, :],
            factor[:, :, None] * said.normal * factor[:, None, :],
            factor * said.right,
        )
