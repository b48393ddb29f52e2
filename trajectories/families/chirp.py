r"""Chirp: a sine of rising frequency on top of another motion, for resonances, backlash and delays.

A joint moves by :math:`e(t)\, a(\omega)\, \sin \varphi(t)` with :math:`\dot\varphi = \omega` from low to
high. The amplitude keeps every quantity within its largest value at every frequency,

.. math:: a(\omega) = \Big(\sum_{i=0}^3 (\omega^i / c_i)^4\Big)^{-1/4} \le \min_i c_i / \omega^i,

with the largest position :math:`c_0`, velocity :math:`c_1`, acceleration :math:`c_2` and jerk :math:`c_3`.
This is a smooth minimum of the four, so that all derivatives exist; it is 16 % smaller where two of the four
are equal. The first three derivatives of the envelope :math:`e` are zero at both ends of its rise and fall.

Derivatives are not written out by hand: they follow from jets, the coefficients :math:`f^{(k)}(t) / k!` of
Taylor series at each instant, shape (order + 1, ..., t), by the recurrences of Griewank and Walther,
Evaluating Derivatives, chapter 13.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import factorial

import numpy as np

from ..errors import BadLimits
from ..trajectory import Extremes, Range, States, Trajectory

SHARP = 4
"""Exponent of the smooth minimum; a larger one is closer to the minimum and has larger derivatives."""
STEP = (0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0)
"""Coefficients of the polynomial from 0 to 1 whose first three derivatives are zero at both ends."""
CELLS = 32
"""Samples per period at the highest frequency for bounds of the extremes, which are 0.5 % too large."""
BOUNDED = 6
"""Coefficients of a jet that a bound needs: the fifth derivative curves the jerk between samples."""


@dataclass(frozen=True, eq=False)
class Chirp(Trajectory):
    """A motion with a chirp on some of its joints."""

    base: Trajectory  # motion under the chirp
    joints: tuple[int, ...]  # joints with a chirp, counted from 0; k of them
    # Largest position, velocity, acceleration and jerk of each joint's chirp for a sine at any of its
    # frequencies, shape (k, 4) [rad, rad/s, rad/s^2, rad/s^3].
    largest: np.ndarray
    low: float  # frequency at the start [Hz]
    high: float  # frequency at the end [Hz]
    begin: float  # time at which the chirp begins [s]
    length: float  # duration of the chirp [s]
    fade: float  # duration of the fade-in and of the fade-out [s]
    logarithmic: bool = True  # whether the frequency doubles in equal times; otherwise it rises linearly

    def __post_init__(self) -> None:
        count = len(self.joints)
        if count == 0 or len(set(self.joints)) < count or not set(self.joints) <= set(range(self.dof)):
            raise BadLimits(f"chirp: joints {self.joints}; expected different ones of 0 to {self.dof - 1}")
        if self.largest.shape != (count, 4) or not np.all(self.largest > 0.0):
            raise BadLimits(
                f"chirp: largest position to jerk are {self.largest.tolist()}; expected shape ({count}, 4), "
                "all above 0"
            )
        if not 0.0 < self.low < self.high < np.inf:
            raise BadLimits(
                f"chirp: from {self.low:g} to {self.high:g} Hz; the frequency must be above 0 and rise. "
                "Try 1 to 20 Hz"
            )
        inside = self.begin >= 0.0 and self.begin + self.length <= self.base.duration * (1 + 1e-12)
        if not (inside and 0.0 < self.fade <= 0.5 * self.length):
            raise BadLimits(
                f"chirp: {self.length:g} s from {self.begin:g} s on, with fades of {self.fade:g} s; it must "
                f"end within the base motion of {self.base.duration:g} s, and a fade last at most half of it"
            )

    @property
    def duration(self) -> float:
        return self.base.duration

    @property
    def dof(self) -> int:
        return self.base.dof

    def at(self, time: np.ndarray) -> States:
        states = self.base.at(time)
        columns = np.stack(states[1:])
        since = states.time - self.begin
        during = (since > 0.0) & (since < self.length)
        waves = derivatives(self._jet(since[during], 4))
        for place, joint in enumerate(self.joints):
            columns[:, during, joint] += waves[:, place]
        return States(states.time, *columns)

    def extremes(self) -> Extremes:
        """Bounds: the sum of the bounds of base and chirp, which need not coincide in time.

        The times of joints with a chirp are those of the chirp.
        """
        ranges = []
        for order, under in enumerate(self.base.extremes()):
            lower, upper, lower_time, upper_time = (np.array(part, float) for part in under)
            for joint, size, when in zip(self.joints, *self._reached, strict=True):
                lower[joint], upper[joint] = lower[joint] - size[order], upper[joint] + size[order]
                lower_time[joint] = upper_time[joint] = self.begin + when[order]
            ranges.append(Range(lower, upper, lower_time, upper_time))
        return Extremes(*ranges)

    def amplitude(self, frequency: np.ndarray) -> np.ndarray:
        """Amplitude of each joint's chirp at frequencies of shape (f,) [Hz]; shape (f, k) [rad]."""
        return (self._crowding(2 * np.pi * np.asarray(frequency, float)[None])[0] ** (-1 / SHARP)).T

    def scaled(self, share: float) -> "Chirp":
        """This chirp with every amplitude multiplied by a share."""
        return replace(self, largest=share * self.largest)

    @property
    def reached(self) -> np.ndarray:
        """Bounds of the absolute values of each joint's chirp alone, position to jerk, shape (k, 4)."""
        return self._reached[0]

    @cached_property
    def _reached(self) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of the absolute position to jerk, and approximately when they are reached [s], each (k, 4).

        Between two samples a distance h apart, no absolute value exceeds the larger of the two by more than
        h^2 / 8 times the largest second derivative, which `_bound` gives for the cell between them.
        """
        left, right = self._edges[:-1], self._edges[1:]
        size = np.abs(derivatives(self._jet(self._edges, 4)))
        curve = derivatives(self._bound(left, right))[2:]
        bound = np.maximum(size[..., :-1], size[..., 1:]) + (right - left) ** 2 / 8 * curve
        worst = np.argmax(bound, axis=-1)
        highest = np.take_along_axis(bound, worst[..., None], axis=-1)[..., 0]
        return highest.T, (0.5 * (left + right))[worst].T

    @property
    def _rate(self) -> float:
        """Change of the frequency [Hz/s], or of its logarithm [1/s]."""
        change = np.log(self.high / self.low) if self.logarithmic else self.high - self.low
        return float(change / self.length)

    def _angular(self, since: np.ndarray, count: int) -> np.ndarray:
        """Jet of the angular frequency with `count` coefficients, none of them negative [rad/s]."""
        line = np.zeros((count, len(since)))
        line[0] = self._rate * since
        line[1:2] = self._rate
        if self.logarithmic:
            return 2 * np.pi * self.low * exponential(line)
        line[0] += self.low
        return 2 * np.pi * line

    def _phase(self, angular: np.ndarray, since: np.ndarray) -> np.ndarray:
        """Jet of the phase, the integral of the angular frequency; one coefficient more [rad]."""
        start = 2 * np.pi * self.low
        first = (angular[0] - start) / self._rate if self.logarithmic else 0.5 * (angular[0] + start) * since
        return np.concatenate([first[None], angular / np.arange(1, len(angular) + 1)[:, None]])

    def _crowding(self, angular: np.ndarray) -> np.ndarray:
        """Jet of each amplitude to the power of -4, shape (count, k, t); no coefficient is negative."""
        raised = product(product(angular, angular), product(angular, angular))[:, None]
        limits = (self.largest**-SHARP).T[:, :, None]
        total = np.zeros((len(angular), len(self.joints), angular.shape[1]))
        for limit in limits[:0:-1]:
            total[0] += limit
            total = product(total, raised)
        total[0] += limits[0]
        return total

    def _envelope(self, since: np.ndarray, count: int) -> np.ndarray:
        """Jet of the envelope [-]."""
        before_end = self.length - since
        rising = since <= before_end
        share = np.minimum(np.where(rising, since, before_end) / self.fade, 1.0)
        slope = np.where(rising, 1.0, -1.0) / self.fade
        step = np.polynomial.Polynomial(STEP)
        flat = share >= 1.0
        return np.stack(
            [
                np.where(flat, float(k == 0), step.deriv(k)(share) * slope**k / factorial(k))
                for k in range(count)
            ]
        )

    def _jet(self, since: np.ndarray, count: int) -> np.ndarray:
        """Jet of each joint's chirp, shape (count, k, t)."""
        angular = self._angular(since, count)
        size = product(self._envelope(since, count)[:, None], power(self._crowding(angular), -1 / SHARP))
        return product(size, sine(self._phase(angular, since)[:count])[:, None])

    @property
    def _edges(self) -> np.ndarray:
        """Edges of the cells in which extremes are bounded; one lies at each switch of the envelope [s]."""
        ends = [0.0, self.fade, self.length - self.fade, self.length]
        pieces = []
        for start, end in zip(ends, ends[1:], strict=False):
            count = int(np.ceil((end - start) * self.high * CELLS)) + 1
            pieces.append(np.linspace(start, end, count, endpoint=False) if end > start else np.empty(0))
        return np.append(np.concatenate(pieces), self.length)

    def _bound(self, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Upper bound of the jet's coefficients inside each cell, shape (6, k, cells).

        The bound is a majorant, factor by factor. Angular frequency, phase and the power of the amplitude
        have no negative coefficients and grow with time, so the right end of the cell has the largest. A
        sine's coefficients are at most those of the exponential whose value is 1. Those of a negative power
        are at most those of (least - rest) to that power, which are all positive.
        """
        angular = self._angular(right, BOUNDED)
        crowding = -self._crowding(angular)
        crowding[0] = self._crowding(self._angular(left, 1))[0]
        phase = self._phase(angular, right)[:BOUNDED]
        phase[0] = 0.0
        size = product(self._largest_envelope(left)[:, None], power(crowding, -1 / SHARP))
        return product(size, exponential(phase)[:, None])

    def _largest_envelope(self, left: np.ndarray) -> np.ndarray:
        """Largest absolute value of each coefficient of the envelope in each cell, shape (6, cells)."""
        fading = (left < self.fade) | (left >= self.length - self.fade)
        out = np.zeros((BOUNDED, len(left)))
        out[0] = 1.0
        for k in range(1, BOUNDED):
            slope = np.polynomial.Polynomial(STEP).deriv(k)
            turns = slope.deriv().roots()
            at = np.concatenate([[0.0, 1.0], np.clip(turns[np.isreal(turns)].real, 0.0, 1.0)])
            out[k, fading] = np.max(np.abs(slope(at))) / (self.fade**k * factorial(k))
        return out


def product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Jet of a product."""
    out = np.zeros(np.broadcast_shapes(left.shape, right.shape))
    for k in range(len(out)):
        out[k] = sum(left[i] * right[k - i] for i in range(k + 1))
    return out


def power(base: np.ndarray, exponent: float) -> np.ndarray:
    """Jet of a power with a real exponent; the base must not be zero."""
    out = np.empty_like(base)
    out[0] = base[0] ** exponent
    for k in range(1, len(out)):
        out[k] = sum((exponent * i - (k - i)) * base[i] * out[k - i] for i in range(1, k + 1))
        out[k] /= k * base[0]
    return out


def exponential(exponent: np.ndarray) -> np.ndarray:
    """Jet of e to a power."""
    out = np.empty_like(exponent)
    out[0] = np.exp(exponent[0])
    for k in range(1, len(out)):
        out[k] = sum(i * exponent[i] * out[k - i] for i in range(1, k + 1)) / k
    return out


def sine(angle: np.ndarray) -> np.ndarray:
    """Jet of the sine of an angle."""
    rising, falling = np.empty_like(angle), np.empty_like(angle)
    rising[0], falling[0] = np.sin(angle[0]), np.cos(angle[0])
    for k in range(1, len(angle)):
        rising[k] = sum(i * angle[i] * falling[k - i] for i in range(1, k + 1)) / k
        falling[k] = -sum(i * angle[i] * rising[k - i] for i in range(1, k + 1)) / k
    return rising


def derivatives(jet: np.ndarray) -> np.ndarray:
    """Derivatives from the coefficients of a jet, in the same shape."""
    return jet * np.array([factorial(k) for k in range(len(jet))]).reshape(-1, *([1] * (jet.ndim - 1)))
