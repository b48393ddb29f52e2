"""Problem: what excitation minimises, under which bounds, as functions of Fourier coefficients.

Coefficients are the rows centre, sines, cosines of every series, shape (k, n) with k = series times
(1 + 2 harmonics); position is basis @ coefficients, and so are its derivatives.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.effects import MotionGradient

from ..families.fourier import Fourier
from ..trajectory import States
from .bounds import Bound, Margins
from .goals import Objective


@dataclass(frozen=True, eq=False)
class Basis:
    """Samples of `series` Fourier series of one period.

    Attributes:
        period: [s].
        harmonics: Number of harmonics.
        samples: Samples of each series in a period, evenly spread.
        series: How many trajectories are planned together.
    """

    period: float
    harmonics: int
    samples: int
    series: int = 1

    @property
    def rows(self) -> int:
        """Coefficients of a joint k."""
        return self.series * (1 + 2 * self.harmonics)

    @cached_property
    def time(self) -> np.ndarray:
        """Time of each sample, one series after the other, shape (t,) [s]."""
        return np.arange(self.series * self.samples) * (self.period / self.samples)

    @cached_property
    def matrices(self) -> list[np.ndarray]:
        """Position, velocity, acceleration and jerk per coefficient, each (t, k)."""
        rate = 2 * np.pi / self.period * np.arange(1, self.harmonics + 1)
        angle = np.outer(self.time[: self.samples], rate)
        constant, sine, cosine = np.ones((self.samples, 1)), np.sin(angle), np.cos(angle)
        found = []
        for _ in range(4):
            one_series = np.concatenate([constant, sine, cosine], axis=1)
            found.append(np.kron(np.eye(self.series), one_series))
            constant, sine, cosine = 0.0 * constant, rate * cosine, -rate * sine
        return found

    def states(self, coefficients: np.ndarray) -> States:
        """States at all samples."""
        return States(self.time, *(matrix @ coefficients for matrix in self.matrices))

    def motion(self, coefficients: np.ndarray) -> Motion:
        """The same without jerk, as effects take it."""
        return self.states(coefficients).motion()

    def pull(self, gradient: MotionGradient) -> np.ndarray:
        """Gradient by the coefficients of what has this gradient by the motion, shape (k, n)."""
        parts = (gradient.position, gradient.velocity, gradient.acceleration)
        return sum(matrix.T @ part for matrix, part in zip(self.matrices[:3], parts, strict=True))

    def fourier(self, coefficients: np.ndarray) -> list[Fourier]:
        """The series themselves."""
        parts = np.split(coefficients.T, self.series, axis=1)
        middle = 1 + self.harmonics
        return [Fourier(self.period, p[:, 0], p[:, 1:middle], p[:, middle:]) for p in parts]

    def coefficients(self, series: list[Fourier]) -> np.ndarray:
        """Inverse of `fourier`."""
        blocks = [np.concatenate([f.centre[:, None], f.sine, f.cosine], axis=1) for f in series]
        return np.concatenate(blocks, axis=1).T


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

    def last(self) -> "Problem":
        """The last smooth objective alone, and the goal that judges it where that is another."""
        first = max(place for place, one in enumerate(self.objectives) if one.smooth)
        return replace(self, objectives=self.objectives[first:])

    def value(self, unknowns: np.ndarray, objective: Objective) -> tuple[float, Callable[[], np.ndarray]]:
        """Objective, and what computes its gradient by the unknowns, shape (k n,)."""
        value, gradient = objective(self._motion(unknowns))
        return value, lambda: (self.basis.pull(gradient()) * self.scale).ravel()

    def _motion(self, unknowns: np.ndarray) -> Motion:
        """The motion itself, the same object where several objectives look at one place in turn."""
        known = self._last.get("unknowns")
        if known is None or not np.array_equal(known, unknowns):
            motion = self.basis.motion(self.coefficients(unknowns))
            self._last.update(unknowns=unknowns.copy(), motion=motion)
        found: Motion = self._last["motion"]
        return found

    @cached_property
    def _last(self) -> dict[str, Any]:
        return {}

    def margins(self, unknowns: np.ndarray) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
        """Margins of all bounds, (r,), and what computes derivatives of some by the unknowns, (m, k n)."""
        matrices = [matrix[:: self.every] for matrix in self.basis.matrices]
        coefficients = self.coefficients(unknowns)
        states = States(self.basis.time[:: self.every], *(matrix @ coefficients for matrix in matrices))
        found = [bound.margins(states) for bound in self.bounds]
        ends = np.cumsum([one.value.size for one in found])

        def slopes(one: Margins, rows: np.ndarray) -> np.ndarray:
            sample, place = np.divmod(rows, one.value.shape[1])
            by = [(m, each) for m, each in zip(matrices, one.slopes(), strict=True) if each is not None]
            parts = [matrix[sample, :, None] * each[sample, place][:, None] for matrix, each in by]
            return np.asarray((sum(parts) * self.scale).reshape(len(rows), unknowns.size))

        def chosen(rows: np.ndarray) -> np.ndarray:
            groups = np.split(rows, np.searchsorted(rows, ends[:-1]))
            starts = ends - [one.value.size for one in found]
            every = zip(found, groups, starts, strict=True)
            return np.concatenate([slopes(one, group - first) for one, group, first in every])

        return np.concatenate([one.value.ravel() for one in found]), chosen
