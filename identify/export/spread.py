"""How well the numbers that simulators take are known, from the parameters that they are made of."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from ..effects.simulator_terms import JointTerms
from ..fit.identified import Standard
from ..model import Model
from ..text_table import NORMAL_95

STEP = 1e-4
"""Of a difference, in deviations of a parameter: intervals need three digits."""


@dataclass(frozen=True, eq=False)
class Spread:
    """Intervals of a model's terms and bodies.

    Attributes:
        model: The model, one column a parameter.
        found: Its parameters.
    """

    model: Model
    found: Standard

    def of_joint(self, place: int, *terms: str) -> np.ndarray:
        """Covariance of terms of one joint, as in `JointTerms`, shape (k, k); infinite where unknown."""
        rows = np.array([self._terms[term][place] for term in terms])
        return self._through(rows, slice(None))

    def half(self, place: int, term: str) -> float:
        """Half of the 95 % interval of one term."""
        return float(NORMAL_95 * np.sqrt(self.of_joint(place, term)[0, 0]))

    def of_body(self, link: int, numbers: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Halves of the 95 % intervals of numbers (k,) that are made of the ten parameters of a link."""
        [own] = [columns for columns in self.model.inertias if columns.start == self._links.start + 10 * link]
        values, std = self.found.values[own], np.sqrt(np.diag(self.found.covariance)[own])
        usual = np.where(np.isfinite(std) & (std > 0.0), std, 1e-6 * (1e-6 + np.abs(values)))
        rows = [
            (numbers(values + step) - numbers(values - step)) / (2.0 * STEP * size)
            for size, step in zip(usual, np.diag(STEP * usual), strict=True)
        ]
        return NORMAL_95 * np.sqrt(np.diag(self._through(np.array(rows).T, own)))

    @property
    def _links(self) -> slice:
        """Columns of the links' parameters."""
        pairs = zip(self.model.effects, self.model.columns, strict=True)
        return next(columns for effect, columns in pairs if effect.of_links)

    @cached_property
    def _terms(self) -> dict[str, np.ndarray]:
        """Terms of joints by parameters, name -> (n, p): each effect's are linear in its own."""
        dof, count = self.model.robot.dof, len(self.found.values)
        found = {f.name: np.zeros((dof, count)) for f in fields(JointTerms)}
        for effect, own in zip(self.model.effects, self.model.columns, strict=True):
            for column, one in zip(range(own.start, own.stop), np.eye(own.stop - own.start), strict=True):
                form = effect.portable(self.model.robot, one)
                if isinstance(form, JointTerms):
                    for name, into in found.items():
                        into[:, column] = getattr(form, name)
        return found

    def _through(self, rows: np.ndarray, columns: slice) -> np.ndarray:
        """Covariance of linear combinations, rows (k, c), of parameters; infinite with what is unknown."""
        covariance = self.found.covariance[columns, columns].copy()
        unknown = np.isinf(np.diag(covariance))
        covariance[unknown, unknown] = 0.0
        spread = rows @ covariance @ rows.T
        open_ = np.any(rows[:, unknown] != 0.0, axis=1)
        spread[open_, open_] = np.inf
        return np.array(spread)


def changed_by(gradient: Sequence[float], covariance: np.ndarray) -> float:
    """Half of the 95 % interval of a number with this gradient; infinite with what is unknown."""
    if not np.all(np.isfinite(covariance)):
        return np.inf
    vector = np.array(gradient)
    return float(NORMAL_95 * np.sqrt(vector @ covariance @ vector))
