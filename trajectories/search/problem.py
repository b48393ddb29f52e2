"""Problem: objectives and bounds of an excitation as functions of Fourier coefficients.

Coefficients are the rows center, sines, cosines of every series, shape (k, n) with k = series times
(1 + 2 harmonics). Position and its derivatives are linear in them: basis @ coefficients.
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
from .bounds import Bound, BoundMargins
from .goals import Objective


@dataclass(frozen=True, eq=False)
class Basis:
    """Samples of `series` Fourier series of one period."""

    period: float  # base period [s]
    harmonics: int  # number of harmonics
    samples: int  # number of evenly spaced samples of each series in a period
    series: int = 1  # number of trajectories that are planned together

    @property
    def rows(self) -> int:
        """Number of coefficients per joint, k."""
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
        matrices = []
        for _ in range(4):
            one_series = np.concatenate([constant, sine, cosine], axis=1)
            matrices.append(np.kron(np.eye(self.series), one_series))
            constant, sine, cosine = 0.0 * constant, rate * cosine, -rate * sine
        return matrices

    def states(self, coefficients: np.ndarray) -> States:
        """States at all samples."""
        return States(self.time, *(matrix @ coefficients for matrix in self.matrices))

    def motion(self, coefficients: np.ndarray) -> Motion:
        """Motion at all samples, as effects take it."""
        return self.states(coefficients).motion()

    def pull(self, gradient: MotionGradient) -> np.ndarray:
        """Gradient by the coefficients, shape (k, n), from the gradient by the motion."""
        parts = (gradient.position, gradient.velocity, gradient.acceleration)
        return sum(matrix.T @ part for matrix, part in zip(self.matrices[:3], parts, strict=True))

    def fourier(self, coefficients: np.ndarray) -> list[Fourier]:
        """The series with these coefficients."""
        parts = np.split(coefficients.T, self.series, axis=1)
        middle = 1 + self.harmonics
        return [Fourier(self.period, p[:, 0], p[:, 1:middle], p[:, middle:]) for p in parts]

    def coefficients(self, series: list[Fourier]) -> np.ndarray:
        """Inverse of `fourier`."""
        blocks = [np.concatenate([f.centre[:, None], f.sine, f.cosine], axis=1) for f in series]
        return np.concatenate(blocks, axis=1).T


@dataclass(frozen=True, eq=False)
class Problem:
    """An objective under bounds over a basis."""

    basis: Basis  # basis of the coefficients, sampled for the objective
    # Objectives to minimize in turn, each from the result of the previous one; smooth ones first.
    objectives: Sequence[Objective]
    bounds: Sequence[Bound]  # bounds to keep
    stride: int  # spacing of the samples at which bounds are checked
    # Size of each coefficient, shape (k, n), or of each joint's coefficients, shape (n,) [rad].
    scale: np.ndarray

    def coefficients(self, unknowns: np.ndarray) -> np.ndarray:
        """Coefficients, shape (k, n), from the solver's unknowns, shape (k n,)."""
        return unknowns.reshape(self.basis.rows, -1) * self.scale

    def unknowns(self, coefficients: np.ndarray) -> np.ndarray:
        """Inverse of `coefficients`."""
        return np.asarray((coefficients / self.scale).ravel())

    def last(self) -> "Problem":
        """This problem with the last smooth objective only, and the nonsmooth goal after it, if any."""
        first = max(place for place, objective in enumerate(self.objectives) if objective.smooth)
        return replace(self, objectives=self.objectives[first:])

    def value(self, unknowns: np.ndarray, objective: Objective) -> tuple[float, Callable[[], np.ndarray]]:
        """Value of an objective, and a function that computes its gradient by the unknowns, shape (k n,)."""
        value, gradient = objective(self._motion(unknowns))
        return value, lambda: (self.basis.pull(gradient()) * self.scale).ravel()

    def _motion(self, unknowns: np.ndarray) -> Motion:
        """The motion, cached for objectives that are evaluated in turn at the same unknowns."""
        known = self._last.get("unknowns")
        if known is None or not np.array_equal(known, unknowns):
            motion = self.basis.motion(self.coefficients(unknowns))
            self._last.update(unknowns=unknowns.copy(), motion=motion)
        cached: Motion = self._last["motion"]
        return cached

    @cached_property
    def _last(self) -> dict[str, Any]:
        return {}

    def margins(self, unknowns: np.ndarray) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
        """Margins of all bounds, (r,), and a function that computes derivatives of some rows, (m, k n)."""
        matrices = [matrix[:: self.stride] for matrix in self.basis.matrices]
        coefficients = self.coefficients(unknowns)
        states = States(self.basis.time[:: self.stride], *(matrix @ coefficients for matrix in matrices))
        bound_margins = [bound.margins(states) for bound in self.bounds]
        ends = np.cumsum([margins.value.size for margins in bound_margins])

        def slopes(margins: BoundMargins, rows: np.ndarray) -> np.ndarray:
            sample, place = np.divmod(rows, margins.value.shape[1])
            pairs = zip(matrices, margins.slopes(), strict=True)
            by_state = [(matrix, slope) for matrix, slope in pairs if slope is not None]
            parts = [matrix[sample, :, None] * slope[sample, place][:, None] for matrix, slope in by_state]
            return np.asarray((sum(parts) * self.scale).reshape(len(rows), unknowns.size))

        def selected_slopes(rows: np.ndarray) -> np.ndarray:
            groups = np.split(rows, np.searchsorted(rows, ends[:-1]))
            starts = ends - [margins.value.size for margins in bound_margins]
            parts = zip(bound_margins, groups, starts, strict=True)
            return np.concatenate([slopes(margins, group - first) for margins, group, first in parts])

        return np.concatenate([margins.value.ravel() for margins in bound_margins]), selected_slopes
