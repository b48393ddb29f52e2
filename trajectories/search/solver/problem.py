"""Problem: what excitation minimises, under which bounds, as functions of Fourier coefficients."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...trajectory import States
from ..bounds.kinematic_bounds import Bound, Margins
from ..information.objective import Objective
from .basis import Basis


@dataclass(frozen=True, eq=False)
class Problem:
    """An objective under bounds over a basis.

    Attributes:
        basis: What the coefficients mean, sampled for the objective.
        objectives: One after the other, each from where the last ended: smooth ones first.
        bounds: What must hold.
        every: One sample in so many is kept to the bounds.
        scale: Size of each coefficient, shape (k, n), or of each joint's, shape (n,) [rad].
    """

    basis: Basis
    objectives: Sequence[Objective]
    bounds: Sequence[Bound]
    every: int
    scale: np.ndarray

    def coefficients(self, unknowns: np.ndarray) -> np.ndarray:
        """Coefficients (k, n) of the solver's unknowns, shape (k n,)."""
        return unknowns.reshape(self.basis.rows, -1) * self.scale

    def unknowns(self, coefficients: np.ndarray) -> np.ndarray:
        """Inverse of `coefficients`."""
        return np.asarray((coefficients / self.scale).ravel())

    def value(self, unknowns: np.ndarray, objective: Objective) -> tuple[float, Callable[[], np.ndarray]]:
        """Objective, and what computes its gradient by the unknowns, shape (k n,)."""
        value, gradient = objective(self.basis.motion(self.coefficients(unknowns)))
        return value, lambda: (self.basis.pull(gradient()) * self.scale).ravel()

    def margins(self, unknowns: np.ndarray) -> tuple[np.ndarray, Callable[[], np.ndarray]]:
        """Margins of all bounds, (r,), and what computes their derivatives by the unknowns, (r, k n)."""
        matrices = [matrix[:: self.every] for matrix in self.basis.matrices]
        coefficients = self.coefficients(unknowns)
        states = States(self.basis.time[:: self.every], *(matrix @ coefficients for matrix in matrices))
        found = [bound.margins(states) for bound in self.bounds]

        def slopes(one: Margins) -> np.ndarray:
            used = [(m, by) for m, by in zip(matrices, one.slopes(), strict=True) if by is not None]
            by = np.stack([by for _, by in used], axis=-1)
            slope = by.reshape(len(by), -1, len(used)) @ np.stack([m for m, _ in used], axis=1)
            slope = slope.reshape(*by.shape[:3], -1).swapaxes(2, 3) * self.scale
            return slope.reshape(one.value.size, -1)

        values = np.concatenate([one.value.ravel() for one in found])
        return values, lambda: np.concatenate([slopes(one) for one in found])
