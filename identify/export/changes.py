"""Changed numbers of a file, with their intervals from the covariance of the standard parameters."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from math import isclose
from typing import NamedTuple

import numpy as np

from ..effects.simulator_terms import JointTerms
from ..fit.identified import Standard
from ..model import Model
from ..text_table import NORMAL_95

SAME = 1e-6
"""Relative difference within which a number is unchanged: rounding in computation and in the file."""
DIGITS = 8
"""Number of significant digits in the file."""
STEP = 1e-4
"""Step of a finite difference, in standard deviations of a parameter: intervals need three digits."""


class Change(NamedTuple):
    """A changed number of the file."""

    where: str  # element, such as "joint 'elbow'"
    attribute: str  # attribute, such as "damping" or "pos x"
    unit: str  # SI unit
    old: float  # number in the file, or the one that MuJoCo computed from the file
    new: float  # new number
    half: float  # half of its 95 % interval; infinite if unknown
    reason: str = ""  # why it changes, if it was not identified by itself

    @property
    def told_apart(self) -> bool:
        """Whether the old number is outside the interval."""
        return abs(self.new - self.old) > self.half


def nearly_equal(old: float, new: float) -> bool:
    """Whether two numbers are equal except for rounding."""
    return isclose(old, new, rel_tol=SAME)


def number_words(values: Iterable[float]) -> str:
    """Text of numbers of one kind; those that are rounding errors of the largest are 0."""
    numbers = np.array(list(values))
    numbers[np.abs(numbers) < 10.0**-DIGITS * np.abs(numbers).max()] = 0.0  # rounding
    return " ".join(f"{value:.{DIGITS}g}" for value in numbers)


@dataclass(frozen=True, eq=False)
class Spread:
    """Intervals of a model's terms and bodies."""

    model: Model  # model with one column per parameter
    standard: Standard  # standard parameters with their covariance

    def of_joint(self, place: int, *terms: str) -> np.ndarray:
        """Covariance of `JointTerms` of one joint, shape (k, k); infinite where unknown."""
        rows = np.array([self._terms[term][place] for term in terms])
        return self._through(rows, slice(None))

    def half(self, place: int, term: str) -> float:
        """Half of the 95 % interval of one term."""
        return float(NORMAL_95 * np.sqrt(self.of_joint(place, term)[0, 0]))

    def half_of(self, weights: Mapping[str, float]) -> float:
        """Half of the 95 % interval of a weighted sum of parameters, by their names."""
        row = np.array([[weights.get(name, 0.0) for name in self.model.names]])
        return float(NORMAL_95 * np.sqrt(self._through(row, slice(None))[0, 0]))

    def of_body(self, link: int, numbers: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Halves of the 95 % intervals of numbers (k,) computed from the ten parameters of a link."""
        pairs = zip(self.model.effects, self.model.columns, strict=True)
        first = next(columns for effect, columns in pairs if effect.of_links).start + 10 * link
        [of_link] = [columns for columns in self.model.inertias if columns.start == first]
        values, std = self.standard.values[of_link], np.sqrt(np.diag(self.standard.covariance)[of_link])
        usual = np.where(np.isfinite(std) & (std > 0.0), std, 1e-6 * (1e-6 + np.abs(values)))
        rows = [
            (numbers(values + step) - numbers(values - step)) / (2.0 * STEP * size)
            for size, step in zip(usual, np.diag(STEP * usual), strict=True)
        ]
        return NORMAL_95 * np.sqrt(np.diag(self._through(np.array(rows).T, of_link)))

    @cached_property
    def _terms(self) -> dict[str, np.ndarray]:
        """Name of a joint term -> its derivative with respect to the parameters, shape (n, p)."""
        dof, count = self.model.robot.dof, len(self.standard.values)
        terms = {f.name: np.zeros((dof, count)) for f in fields(JointTerms)}
        for effect, columns in zip(self.model.effects, self.model.columns, strict=True):
            units = np.eye(columns.stop - columns.start)
            for column, unit in zip(range(columns.start, columns.stop), units, strict=True):
                form = effect.portable(self.model.robot, unit)
                if isinstance(form, JointTerms):
                    for name, term in terms.items():
                        term[:, column] = getattr(form, name)
        return terms

    def _through(self, rows: np.ndarray, columns: slice) -> np.ndarray:
        """Covariance of linear combinations (k, c) of parameters; infinite if they include unknown ones."""
        covariance = self.standard.covariance[columns, columns].copy()
        unknown = np.isinf(np.diag(covariance))
        covariance[unknown, unknown] = 0.0
        spread = rows @ covariance @ rows.T
        open_ = np.any(rows[:, unknown] != 0.0, axis=1)
        spread[open_, open_] = np.inf
        return np.array(spread)


def changed_by(gradient: Sequence[float], covariance: np.ndarray) -> float:
    """Half of the 95 % interval of a number with this gradient; infinite if the covariance is."""
    if not np.all(np.isfinite(covariance)):
        return np.inf
    vector = np.array(gradient)
    return float(NORMAL_95 * np.sqrt(vector @ covariance @ vector))
