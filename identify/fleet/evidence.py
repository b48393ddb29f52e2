"""Evidence: how much better a further change, of any suspect, would explain the runs of an arm."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import linalg

from .says import Sums
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
