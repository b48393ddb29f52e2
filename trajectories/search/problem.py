"""Problem: objectives and bounds of an excitation as functions of Fourier coefficients.

Bounds are margins that are positive inside. Each is relative to its limit, so that 0.01 is one percent of the
room. Rates and torques have a margin to the nearer of their two limits only: this halves the number of rows
for the solver, and is smooth where it matters, since at zero both limits are far away.

Coefficients are the rows center, sines, cosines of every series, shape (k, n) with k = series times
(1 + 2 harmonics). Position and its derivatives are linear in them: basis @ coefficients.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import MotionGradient

from ..clearances.clearance import Clearance
from ..families.fourier import Fourier
from ..limits.brake import stopping_reach, stopping_reach_gradient
from ..limits.usable_limits import ranges
from ..trajectory import States
from .goals import Objective

Slopes = tuple[np.ndarray | None, np.ndarray | None, np.ndarray | None, np.ndarray | None]
"""Derivatives by position, velocity, acceleration and jerk, each (t, m, n), or None for zero."""


class BoundMargins(NamedTuple):
    """Margins of some rows at each sample, and their derivatives by the state there."""

    value: np.ndarray  # margins, at least zero where allowed, shape (t, m) [-]
    # Function that computes the derivatives, which cost more and are needed less often.
    slopes: Callable[[], Slopes]


class Bound(ABC):
    """A constraint on the state at every sample."""

    @abstractmethod
    def margins(self, states: States) -> BoundMargins:
        """Margins and their derivatives."""


@dataclass(frozen=True, eq=False)
class RateBound(Bound):
    """Velocity, acceleration or jerk within its limits."""

    order: int  # 1 for velocity, 2 for acceleration, 3 for jerk
    lower: np.ndarray  # lower limits, below zero, shape (n,)
    upper: np.ndarray  # upper limits, above zero, shape (n,)
    joints: np.ndarray  # joints to which the bound applies, shape (k,)

    def margins(self, states: States) -> BoundMargins:
        value = (states.velocity, states.acceleration, states.jerk)[self.order - 1][:, self.joints]
        lower, upper = self.lower[self.joints], self.upper[self.joints]
        nearer = np.where(value > 0.0, upper, lower)

        def slopes() -> Slopes:
            slope = np.zeros((*value.shape, len(self.upper)))
            slope[:, np.arange(len(self.joints)), self.joints] = -1.0 / nearer
            return tuple(slope if order == self.order else None for order in range(4))  # type: ignore[return-value]

        return BoundMargins(1.0 - value / nearer, slopes)


@dataclass(frozen=True, eq=False)
class StopBound(Bound):
    """Position, and the extreme positions of a stop that begins now, within the position limits."""

    limits: Limits  # limits of all kinds; the stop uses those of acceleration and jerk

    def margins(self, states: States) -> BoundMargins:
        lower, upper = self.limits.position_lower, self.limits.position_upper
        room = 0.5 * (upper - lower)
        down, up = stopping_reach(states.velocity, states.acceleration, self.limits)
        value = [(upper - states.position - up) / room, (states.position + down - lower) / room]

        def slopes() -> Slopes:
            position = _diagonal(np.concatenate([-1.0 / room, 1.0 / room]), len(up))
            velocity, acceleration = (
                _diagonal(np.concatenate([-by.upper / room, by.lower / room], axis=1), len(up))
                for by in stopping_reach_gradient(states.velocity, states.acceleration, self.limits)
            )
            return position, velocity, acceleration, None

        return BoundMargins(np.concatenate(value, axis=1), slopes)


def _diagonal(values: np.ndarray, samples: int) -> np.ndarray:
    """Derivatives of two rows per joint, each by its joint; values (2 n,) or (t, 2 n) to (t, 2 n, n)."""
    values = np.broadcast_to(values, (samples, values.shape[-1]))
    joints = values.shape[1] // 2
    out = np.zeros((samples, 2 * joints, joints))
    rows = np.arange(2 * joints)
    out[:, rows, rows % joints] = values
    return out


def kinematic_bounds(limits: Limits, highest: float = np.inf) -> list[Bound]:
    """Bounds of position with room to stop, velocity, acceleration and jerk, whose limits are finite.

    The derivative of a series bounded by v is at most the frequency of its highest harmonic [rad/s] times v
    (Bernstein's inequality), so a looser limit of the derivative needs no bound.
    """
    bounds: list[Bound] = [StopBound(limits)]
    steepest = np.full(len(limits.velocity), np.inf)
    for order, (lower, upper) in enumerate(list(ranges(limits).values())[1:], start=1):
        joints = np.flatnonzero(np.minimum(-lower, upper) < steepest)
        if len(joints):
            bounds.append(RateBound(order, lower, upper, joints))
        steepest = highest * np.minimum(np.maximum(-lower, upper), steepest)
    return bounds


SCALE = 0.1
"""Distance that is scaled like the full range of a joint [m]: about a link's thickness."""


@dataclass(frozen=True, eq=False)
class ClearanceBound(Bound):
    """Margins of a clearance at every sample."""

    clearance: Clearance

    def margins(self, states: States) -> BoundMargins:
        value, slope = self.clearance.gradient(states.position)
        return BoundMargins(value / SCALE, lambda: (slope / SCALE, None, None, None))


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
        value, gradient = objective(self._motion(unknowns.tobytes()))
        return value, lambda: (self.basis.pull(gradient()) * self.scale).ravel()

    @cached_property
    def _motion(self) -> Callable[[bytes], Motion]:
        """The motion of unknowns, kept for objectives that are evaluated in turn at the same ones."""
        return lru_cache(maxsize=1)(
            lambda unknowns: self.basis.motion(self.coefficients(np.frombuffer(unknowns)))
        )

    def margins(self, unknowns: np.ndarray) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
        """Margins of all bounds, (r,), and a function that computes derivatives of some rows, (m, k n)."""
        matrices = [matrix[:: self.stride] for matrix in self.basis.matrices]
        coefficients = self.coefficients(unknowns)
        states = States(self.basis.time[:: self.stride], *(matrix @ coefficients for matrix in matrices))
        bound_margins = [bound.margins(states) for bound in self.bounds]
        values = [margins.value.ravel() for margins in bound_margins]
        starts = np.cumsum([0, *(len(value) for value in values[:-1])])

        def slopes(margins: BoundMargins, rows: np.ndarray) -> np.ndarray:
            sample, place = np.divmod(rows, margins.value.shape[1])
            pairs = zip(matrices, margins.slopes(), strict=True)
            by_state = [(matrix, slope) for matrix, slope in pairs if slope is not None]
            parts = [matrix[sample, :, None] * slope[sample, place][:, None] for matrix, slope in by_state]
            return np.asarray((sum(parts) * self.scale).reshape(len(rows), unknowns.size))

        def selected_slopes(rows: np.ndarray) -> np.ndarray:
            groups = np.split(rows, np.searchsorted(rows, starts[1:]))
            parts = zip(bound_margins, groups, starts, strict=True)
            return np.concatenate([slopes(margins, group - first) for margins, group, first in parts])

        return np.concatenate(values), selected_slopes
