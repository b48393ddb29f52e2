"""Evidence: how much better a further change, of any suspect, would explain the runs of an arm."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import linalg
from scipy.linalg.lapack import dpotrf, dpotri

from .suspects import Suspect

STEP, CREEP = SHAPES = "step", "creep"


class Questions(NamedTuple):
    """Suspects, prepared for the computation of evidence.

    Attributes:
        single: Indices of suspects with one amount, shape (s,).
        columns: Change of the unknowns for a typical amount of each of these, shape (s, m).
        several: Indices of the other suspects, each with the columns of its typical amounts, (k, m).
        steps_only: Indices of suspects that do not creep.
        number: Number of suspects.
    """

    single: np.ndarray
    columns: np.ndarray
    several: tuple[tuple[int, np.ndarray], ...]
    steps_only: frozenset[int]
    number: int

    @classmethod
    def of(cls, suspects: Sequence[Suspect]) -> "Questions":
        """Questions about all suspects."""
        scaled = [suspect.columns * suspect.std[:, None] for suspect in suspects]
        single = [k for k, columns in enumerate(scaled) if len(columns) == 1]
        several = tuple((k, columns) for k, columns in enumerate(scaled) if len(columns) > 1)
        steps_only = frozenset(k for k, suspect in enumerate(suspects) if suspect.steps_only)
        columns = np.concatenate([scaled[k] for k in single])
        return cls(np.array(single), columns, several, steps_only, len(suspects))


@dataclass(frozen=True, eq=False)
class Evidence:
    """Contribution of a change from `start` on, of any suspect: precision (m, m) and right-hand side (m,)."""

    start: int
    shape: str
    precision: np.ndarray
    right: np.ndarray

    def gains(self, questions: Questions) -> np.ndarray:
        """Log-likelihood gain by each suspect, with the amounts integrated out, shape (`number`,).

        The gain is minus infinity for a creep of a suspect that does not creep.
        """
        gains, columns = np.full(questions.number, -np.inf), questions.columns
        variances = 1.0 + np.einsum("km,km->k", columns @ self.precision, columns)
        gains[questions.single] = 0.5 * ((columns @ self.right) ** 2 / variances - np.log(variances))
        for k, several in questions.several:
            if self.shape == STEP or k not in questions.steps_only:
                gains[k] = self._gain(several)
        return gains

    def _gain(self, columns: np.ndarray) -> float:
        inner = np.eye(len(columns)) + columns @ self.precision @ columns.T
        side, lower = columns @ self.right, linalg.cholesky(inner, lower=True, check_finite=False)
        solved = linalg.solve_triangular(lower, side, lower=True, check_finite=False)
        return float(0.5 * solved @ solved - np.sum(np.log(np.diag(lower))))


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


def evidence_from(
    start: int,
    series: Mapping[str, np.ndarray],
    current: Sums,
    after: Sums,
    before: np.ndarray,
    weight: np.ndarray,
) -> list[Evidence]:
    """Evidence for a change from one run on, for each shape.

    Args:
        start: First run after the change.
        series: Share of the change in each run, shape (r,), by shape.
        current: Sums over runs with their current noise.
        after: Sums over runs with the noise assumed from the change on.
        before: Prior mean of the arm's unknowns and amounts, shape (d,).
        weight: Prior precision of these, shape (d,).
    """
    normal = current.normal[:start].sum(axis=0) + after.normal[start:].sum(axis=0)
    right = current.right[:start].sum(axis=0) + after.right[start:].sum(axis=0)
    lower = linalg.cholesky(normal + np.diag(weight), lower=True, check_finite=False)
    half = linalg.solve_triangular(lower, right + weight * before, lower=True, check_finite=False)
    evidence = []
    for shape, shares in series.items():
        share = shares[start:]
        across = np.tensordot(share, after.across[start:], axes=1)
        projected = linalg.solve_triangular(lower, across, lower=True, check_finite=False)
        precision = np.tensordot(share**2, after.change_normal[start:], axes=1) - projected.T @ projected
        side = share @ after.change_right[start:] - projected.T @ half
        evidence.append(Evidence(start, shape, precision, side))
    return evidence
