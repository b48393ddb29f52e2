"""Fourier series: the periodic trajectory of most identification runs."""

from dataclasses import dataclass

import numpy as np

from ..errors import BadLimits
from ..trajectory import Extremes, Range, States, Trajectory

SHORTEST = 1e-9
"""Shortest period [s]: the nanosecond, in which controllers count time."""
NEGLIGIBLE = 1e-13
"""Share of the largest coefficient below which the highest harmonic is rounding and would make the polynomial
of the extrema degenerate."""


@dataclass(frozen=True, eq=False)
class Fourier(Trajectory):
    r"""Position :math:`c + \sum_k s_k \sin(k \omega t) + c_k \cos(k \omega t)`, :math:`\omega = 2\pi/T`."""

    period: float  # base period T [s]
    centre: np.ndarray  # center c, shape (n,) [rad]
    sine: np.ndarray  # sine coefficients, shape (n, harmonics) [rad]
    cosine: np.ndarray  # cosine coefficients, shape (n, harmonics) [rad]
    periods: int = 1  # number of periods

    def __post_init__(self) -> None:
        if not (SHORTEST <= self.period < np.inf and self.periods >= 1):
            raise BadLimits(
                f"Fourier: period {self.period:g} s, {self.periods} times; expected at least "
                f"{SHORTEST:g} s, once"
            )
        if self.sine.shape != self.cosine.shape or self.sine.shape[:1] != self.centre.shape:
            raise BadLimits(
                f"Fourier: centre {self.centre.shape}, sine {self.sine.shape}, cosine {self.cosine.shape}; "
                "expected (n,), (n, harmonics), (n, harmonics)"
            )

    @property
    def duration(self) -> float:
        return self.period * self.periods

    @property
    def dof(self) -> int:
        return len(self.centre)

    @property
    def harmonics(self) -> int:
        """Number of harmonics."""
        return int(self.sine.shape[1])

    @property
    def frequencies(self) -> np.ndarray:
        """Angular frequency of each harmonic, shape (harmonics,) [rad/s]."""
        return 2 * np.pi / self.period * np.arange(1, self.harmonics + 1)

    def at(self, time: np.ndarray) -> States:
        time = self.inside(time)
        angle = np.outer(time, self.frequencies)
        wave = np.concatenate([np.sin(angle), np.cos(angle)], axis=1)
        columns = [wave @ weight.T for weight in self._derivatives()]
        return States(time, self.centre + columns[0], *columns[1:])

    def _derivatives(self) -> list[np.ndarray]:
        """Sine and cosine coefficients of the series and its three derivatives, each (n, 2 harmonics)."""
        coefficients, sine, cosine = [], self.sine, self.cosine
        for _ in range(4):
            coefficients.append(np.concatenate([sine, cosine], axis=1))
            sine, cosine = -self.frequencies * cosine, self.frequencies * sine
        return coefficients

    def extremes(self) -> Extremes:
        ranges = []
        for coefficients in self._derivatives():
            sine, cosine = np.split(coefficients, 2, axis=1)
            ranges.append(self._range(sine, cosine))
        position = ranges[0]
        lifted = position._replace(lower=position.lower + self.centre, upper=position.upper + self.centre)
        return Extremes(lifted, *ranges[1:])

    def _range(self, sine: np.ndarray, cosine: np.ndarray) -> Range:
        """Extremes of each row's trigonometric polynomial."""
        rows = [_extremes_of(s, c) for s, c in zip(sine, cosine, strict=True)]
        lower, upper, lower_angle, upper_angle = np.array(rows).T
        to_time = self.period / (2 * np.pi)
        return Range(lower, upper, lower_angle * to_time, upper_angle * to_time)

    def shifted(self, by: float) -> "Fourier":
        """This motion, begun `by` seconds later in its period."""
        angle = self.frequencies * by
        sine = self.sine * np.cos(angle) - self.cosine * np.sin(angle)
        cosine = self.cosine * np.cos(angle) + self.sine * np.sin(angle)
        return Fourier(self.period, self.centre, sine, cosine, self.periods)

    def scaled(self, share: float | np.ndarray) -> "Fourier":
        """This motion with excursions from its center times `share`, a scalar or shape (n,) [-]."""
        column = np.reshape(share, (-1, 1))
        return Fourier(self.period, self.centre, column * self.sine, column * self.cosine, self.periods)


def _extremes_of(sine: np.ndarray, cosine: np.ndarray) -> tuple[float, float, float, float]:
    """Smallest and largest value of a trigonometric polynomial without constant, and their angles.

    With z = exp(i angle) its derivative is a polynomial of twice the degree, whose roots on the unit circle
    are the extrema. The angles of all roots are candidates, so that rounding cannot lose an extremum.
    """
    order = np.arange(1, len(sine) + 1)
    half = 0.5 * order * (sine + 1j * cosine)  # the derivative is the sum of half * z^k and its conjugate
    largest = np.max(np.abs(half), initial=0.0)
    if largest == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    half = half[: 1 + int(np.flatnonzero(np.abs(half) > NEGLIGIBLE * largest)[-1])]
    polynomial = np.concatenate([half[::-1], [0.0], np.conj(half)])
    angles = np.mod(np.angle(np.roots(polynomial)), 2 * np.pi)
    waves = np.outer(angles, order)
    values = np.sin(waves) @ sine + np.cos(waves) @ cosine
    low, high = int(np.argmin(values)), int(np.argmax(values))
    return float(values[low]), float(values[high]), float(angles[low]), float(angles[high])
