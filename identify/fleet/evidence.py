"""Evidence: what a further change would explain of an arm's runs, whatever changed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import linalg

from .says import Sums
from .suspects import Suspect

STEP, CREEP = SHAPES = "step", "creep"


class Questions(NamedTuple):
    """Suspects as they are asked for.

    Attributes:
        single: Places of those with one amount, shape (s,), and
        columns: change of the unknowns for a usual amount of each, shape (s, m).
        several: Places of the others, each with the columns of its usual amounts, (k, m).
        steps_only: Places of those that do not creep.
        number: Of all.
    """

    single: np.ndarray
    columns: np.ndarray
    several: tuple[tuple[int, np.ndarray], ...]
    steps_only: frozenset[int]
    number: int

    @classmethod
    def of(cls, suspects: Sequence[Suspect]) -> "Questions":
        """From all suspects."""
        scaled = [one.columns * one.std[:, None] for one in suspects]
        single = [k for k, one in enumerate(scaled) if len(one) == 1]
        several = tuple((k, one) for k, one in enumerate(scaled) if len(one) > 1)
        steps_only = frozenset(k for k, one in enumerate(suspects) if one.steps_only)
        columns = np.concatenate([scaled[k] for k in single])
        return cls(np.array(single), columns, several, steps_only, len(suspects))


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a change from `start` on, of any suspect, would add: precision (m, m) and right-hand side (m,)."""

    start: int
    shape: str
    precision: np.ndarray
    right: np.ndarray

    def gains(self, asked: Questions) -> np.ndarray:
        """Logarithms of the factors by which runs are more probable, amounts integrated out.

        One a suspect; minus infinity where it does not creep and this is a creep.
        """
        found, columns = np.full(asked.number, -np.inf), asked.columns
        own = 1.0 + np.einsum("km,km->k", columns @ self.precision, columns)
        found[asked.single] = 0.5 * ((columns @ self.right) ** 2 / own - np.log(own))
        for k, several in asked.several:
            if self.shape == STEP or k not in asked.steps_only:
                found[k] = self._gain(several)
        return found

    def _gain(self, columns: np.ndarray) -> float:
        inner = np.eye(len(columns)) + columns @ self.precision @ columns.T
        side, lower = columns @ self.right, linalg.cholesky(inner, lower=True, check_finite=False)
        solved = linalg.solve_triangular(lower, side, lower=True, check_finite=False)
        return float(0.5 * solved @ solved - np.sum(np.log(np.diag(lower))))


def evidence_from(
    start: int,
    series: Mapping[str, np.ndarray],
    own: Sums,
    after: Sums,
    before: np.ndarray,
    weight: np.ndarray,
) -> list[Evidence]:
    """What a change from one run on would explain, for each shape.

    Args:
        start: First run after the change.
        series: How much of it each run has, shape (r,), by shape.
        own: Of runs as they are explained so far.
        after: Of those from the change on.
        before: Mean of the arm's unknowns and amounts before any run, shape (d,), and
        weight: their precision, shape (d,).
    """
    normal = own.normal[:start].sum(axis=0) + after.normal[start:].sum(axis=0)
    right = own.right[:start].sum(axis=0) + after.right[start:].sum(axis=0)
    lower = linalg.cholesky(normal + np.diag(weight), lower=True, check_finite=False)
    half = linalg.solve_triangular(lower, right + weight * before, lower=True, check_finite=False)
    found = []
    for shape, whole in series.items():
        some = whole[start:]
        across = np.tensordot(some, after.across[start:], axes=1)
        turned = linalg.solve_triangular(lower, across, lower=True, check_finite=False)
        precision = np.tensordot(some**2, after.own[start:], axes=1) - turned.T @ turned
        found.append(Evidence(start, shape, precision, some @ after.side[start:] - turned.T @ half))
    return found
