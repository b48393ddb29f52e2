"""Basis: the motion of several Fourier series as a linear function of their coefficients.

Coefficients are the rows centre, sines, cosines of every series, shape (k, n) with k = series times
(1 + 2 harmonics); position is basis @ coefficients, and so are its derivatives.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from exidyn.identify.arm.motion import Motion
from exidyn.identify.effects import MotionGradient

from ...families.fourier import Fourier
from ...trajectory import States


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
