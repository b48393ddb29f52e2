"""Problem: what excitation minimises, under which bounds, as functions of Fourier coefficients."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from exidyn.identify.arm.motion import Motion
from exidyn.identify.effects import MotionGradient

from ..trajectory import States
from .basis import Basis
from .bounds import Bound, Margins
from .criteria import Criterion
from .information import Experiment


class Objective(Protocol):
    """A number that a motion makes, to be minimised."""

    def __call__(self, motion: Motion) -> tuple[float, Callable[[], MotionGradient]]:
        """Value, and what computes its gradient by the motion: a line search asks for the value alone."""

    def value(self, motion: Motion) -> float:
        """Value alone."""
        return self(motion)[0]


@dataclass(frozen=True, eq=False)
class Informative(Objective):
    """Objective: a criterion of the information that an experiment gives per run of unit length.

    Attributes:
        experiment: Unknowns and runs.
        criterion: Of the information.
        size: Of each base parameter, shape (b,).
        rows: Independent rows a second that count, times the seconds of the run; only their sum with
            earlier information depends on it.
    """

    experiment: Experiment
    criterion: Criterion
    size: np.ndarray
    rows: float = 1.0

    def __call__(self, motion: Motion) -> tuple[float, Callable[[], MotionGradient]]:
        share = self.rows / len(motion)
        columns = self.experiment.columns(motion)
        information = self.experiment.gathered(columns, share)
        value, by = self.criterion(information, self.size)
        return value, lambda: self.experiment.pull(motion, columns, by, share)


@dataclass(frozen=True, eq=False)
class Problem:
    """An objective under bounds over a basis.

    Attributes:
        basis: What the coefficients mean, sampled for the objective.
        objectives: One after the other, each from where the last ended: smooth ones first.
        bounds: What must hold.
        every: One sample in so many is kept to the bounds.
        scale: Size of each joint's coefficients, shape (n,) [rad].
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
            slope = sum(
                np.einsum("tk,tmn->tmkn", matrix, by * self.scale, optimize=True)
                for matrix, by in zip(matrices, one.slopes(), strict=True)
                if by is not None
            )
            return np.asarray(slope).reshape(one.value.size, -1)

        values = np.concatenate([one.value.ravel() for one in found])
        return values, lambda: np.concatenate([slopes(one) for one in found])
