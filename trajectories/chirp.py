r"""Chirp: on top of another motion, a sine whose frequency rises; for resonances, backlash and delays.

Joint j moves by :math:`e(t)\, a_j(\omega)\, \sin \varphi(t)` with :math:`\dot\varphi = \omega` from low to
high. The amplitude gives every quantity its share at every frequency,

.. math:: a_j(\omega) = \Big(\sum_{i=0}^3 (\omega^i / c_{ij})^4\Big)^{-1/4} \le \min_i c_{ij} / \omega^i,

with the largest position :math:`c_0`, velocity :math:`c_1`, acceleration :math:`c_2` and jerk :math:`c_3`: the
smallest of the four without its corners, so that all derivatives exist. Where two of the four are equal
that costs 16 %. The envelope :math:`e` rises and falls with three derivatives that are zero at its ends.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import factorial

import numpy as np

from .errors import BadLimits
from .jets import derivatives, exponential, power, product, sine
from .trajectory import Extremes, Range, States, Trajectory

SHARP = 4
"""Power of the mean; the larger, the nearer to the smallest of the four, and the larger its derivatives."""
STEP = (0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0)
"""Coefficients of the polynomial from 0 to 1 whose first three derivatives are zero at both."""
CELLS = 32
"""Samples a period at the highest frequency from which extremes are bounded; 0.5 % is lost to the proof."""
BOUNDED = 6
"""Coefficients of a jet that a bound needs: the fifth derivative curves the jerk between samples."""


@dataclass(frozen=True, eq=False)
class Chirp(Trajectory):
    """A motion with a chirp on some of its joints.

    Attributes:
        base: What the joints do otherwise.
        joints: Which have the chirp, counted from 0; k of them.
        largest: Position, velocity, acceleration and jerk of each joint's chirp that a sine of any of its
            frequencies keeps to, shape (k, 4) [rad, rad/s, rad/s^2, rad/s^3].
        low: Frequency at the start [Hz].
        high: Frequency at the end [Hz].
        begin: When the chirp begins [s].
        length: How long it lasts [s].
        fade: How long it rises, and falls [s].
        logarithmic: Whether the frequency doubles in equal times; otherwise it rises evenly.
    """

    base: Trajectory
    joints: tuple[int, ...]
    largest: np.ndarray
    low: float
    high: float
    begin: float
    length: float
    fade: float
    logarithmic: bool = True

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
                f"chirp: from {self.low:g} to {self.high:g} Hz; it must rise, from above 0. Try 1 to 20 Hz"
            )
        inside = self.begin >= 0.0 and self.begin + self.length <= self.base.duration * (1 + 1e-12)
        if not (inside and 0.0 < self.fade <= 0.5 * self.length):
            raise BadLimits(
                f"chirp: {self.length:g} s from {self.begin:g} s on, rising and falling for {self.fade:g} s; the "
                f"motion under it lasts {self.base.duration:g} s, and half of the chirp is the longest rise"
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
        for place, joint in enumerate(self.joints):
            columns[:, during, joint] += derivatives(self._jet(since[during], place))
        return States(states.time, *columns)

    def extremes(self) -> Extremes:
        """Bounds: those of the base and of the chirp added, though they need not meet at one time.

        The times are those of the chirp, where it has any.
        """
        found = []
        for order, under in enumerate(self.base.extremes()):
            lower, upper, lower_time, upper_time = (np.array(part, float) for part in under)
            for place, joint in enumerate(self.joints):
                size, when = self._reached[place, order]
                lower[joint], upper[joint] = lower[joint] - size, upper[joint] + size
                lower_time[joint] = upper_time[joint] = when
            found.append(Range(lower, upper, lower_time, upper_time))
        return Extremes(*found)

    def frequency(self, time: np.ndarray) -> np.ndarray:
        """Frequency at times during the chirp, shape (t,) [Hz]."""
        return self._angular(np.asarray(time, float) - self.begin, 1)[0] / (2 * np.pi)

    def amplitude(self, frequency: np.ndarray) -> np.ndarray:
        """Amplitude of each joint's chirp at frequencies of shape (f,) [Hz]; shape (f, k) [rad]."""
        angular = 2 * np.pi * np.asarray(frequency, float)[None]
        each = [self._crowding(angular, place)[0] ** (-1 / SHARP) for place in range(len(self.joints))]
        return np.stack(each, axis=-1)

    def scaled(self, share: float) -> "Chirp":
        """The same with every amplitude times a share."""
        return replace(self, largest=share * self.largest)

    @property
    def reached(self) -> np.ndarray:
        """Bounds of the size of each joint's chirp alone, position to jerk, shape (k, 4)."""
        return self._reached[:, :, 0]

    def _angular(self, since: np.ndarray, count: int) -> np.ndarray:
        """Jet of the angular frequency with `count` coefficients, none of them negative [rad/s]."""
        rate = np.log(self.high / self.low) if self.logarithmic else self.high - self.low
        line = np.zeros((count, len(since)))
        line[0] = rate / self.length * since
        line[1:2] = rate / self.length
        if self.logarithmic:
            return 2 * np.pi * self.low * exponential(line)
        line[0] += self.low
        return 2 * np.pi * line

    def _phase(self, angular: np.ndarray, since: np.ndarray) -> np.ndarray:
        """Jet of the phase, the integral of the angular frequency; one coefficient more [rad]."""
        rate = np.log(self.high / self.low) if self.logarithmic else self.high - self.low
        start, rate = 2 * np.pi * self.low, rate / self.length
        first = (angular[0] - start) / rate if self.logarithmic else 0.5 * (angular[0] + start) * since
        return np.concatenate([first[None], angular / np.arange(1, len(angular) + 1)[:, None]])

    def _crowding(self, angular: np.ndarray, place: int) -> np.ndarray:
        """Jet of the amplitude to the power of -4: rises with the frequency, all coefficients positive."""
        raised = product(product(angular, angular), product(angular, angular))
        limits = self.largest[place] ** -SHARP
        total = np.zeros_like(angular)
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

    def _jet(self, since: np.ndarray, place: int, count: int = 4) -> np.ndarray:
        """Jet of one joint's chirp, shape (count, t)."""
        angular = self._angular(since, count)
        size = product(self._envelope(since, count), power(self._crowding(angular, place), -1 / SHARP))
        return product(size, sine(self._phase(angular, since)[:count]))

    @cached_property
    def _reached(self) -> np.ndarray:
        """Bound of the size of position to jerk of each joint, and when; shape (k, 4, 2).

        Between two samples a distance h apart no quantity is further from zero than at the larger plus
        h^2 / 8 times the largest second derivative, which `_bound` has for the cell between.
        """
        edges = self._edges
        left, right = edges[:-1], edges[1:]
        found = np.empty((len(self.joints), 4, 2))
        for place in range(len(self.joints)):
            size = np.abs(derivatives(self._jet(edges, place)))
            curve = derivatives(self._bound(left, right, place))[2:]
            bound = np.maximum(size[:, :-1], size[:, 1:]) + (right - left) ** 2 / 8 * curve
            worst = np.argmax(bound, axis=1)
            found[place, :, 0] = bound[np.arange(4), worst]
            found[place, :, 1] = self.begin + 0.5 * (left + right)[worst]
        return found

    @property
    def _edges(self) -> np.ndarray:
        """Cells between which extremes are bounded; where the envelope changes its formula one ends [s]."""
        ends = [0.0, self.fade, self.length - self.fade, self.length]
        pieces = []
        for start, end in zip(ends, ends[1:], strict=False):
            count = int(np.ceil((end - start) * self.high * CELLS)) + 1
            pieces.append(np.linspace(start, end, count, endpoint=False) if end > start else np.empty(0))
        return np.append(np.concatenate(pieces), self.length)

    def _bound(self, left: np.ndarray, right: np.ndarray, place: int) -> np.ndarray:
        """Jet whose coefficients no jet inside a cell exceeds, shape (6, cells).

        Majorants, factor by factor: angular frequency, phase and the power of the amplitude have no
        negative coefficient that grows with time, so the cell's right end has the largest. A sine's
        coefficients are at most those of the exponential with its value taken as 1; those of a negative
        power at most those of (least - rest) to that power, of which all are positive.
        """
        angular = self._angular(right, BOUNDED)
        crowding = -self._crowding(angular, place)
        crowding[0] = self._crowding(self._angular(left, 1), place)[0]
        phase = self._phase(angular, right)[:BOUNDED]
        phase[0] = 0.0
        size = product(self._largest_envelope(left), power(crowding, -1 / SHARP))
        return product(size, exponential(phase))

    def _largest_envelope(self, left: np.ndarray) -> np.ndarray:
        """Largest size of each coefficient of the envelope in each cell, shape (6, cells)."""
        fading = (left < self.fade) | (left >= self.length - self.fade)
        out = np.zeros((BOUNDED, len(left)))
        out[0] = 1.0
        for k in range(1, BOUNDED):
            slope = np.polynomial.Polynomial(STEP).deriv(k)
            turns = slope.deriv().roots()
            at = np.concatenate([[0.0, 1.0], np.clip(turns[np.isreal(turns)].real, 0.0, 1.0)])
            out[k, fading] = np.max(np.abs(slope(at))) / (self.fade**k * factorial(k))
        return out
