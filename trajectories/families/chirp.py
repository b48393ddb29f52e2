"""Chirp: a sine of rising frequency on top of another motion, for resonances, backlash and delays."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..errors import BadLimits
from ..trajectory import Extremes, Range, States, Trajectory
from .chirp_wave import ChirpWave


@dataclass(frozen=True, eq=False)
class Chirp(Trajectory):
    """A motion with a chirp on some of its joints.

    Attributes:
        base: Motion under the chirp.
        joints: Joints with a chirp, counted from 0; k of them.
        largest: Largest position, velocity, acceleration and jerk of each joint's chirp for a sine at any of
            its frequencies, shape (k, 4) [rad, rad/s, rad/s^2, rad/s^3].
        low: Frequency at the start [Hz].
        high: Frequency at the end [Hz].
        begin: Time at which the chirp begins [s].
        length: Duration of the chirp [s].
        fade: Duration of the fade-in and of the fade-out [s].
        logarithmic: Whether the frequency doubles in equal times; otherwise it rises linearly.
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
        for joint, wave in zip(self.joints, self._waves, strict=True):
            columns[:, during, joint] += wave.states(since[during])
        return States(states.time, *columns)

    def extremes(self) -> Extremes:
        """Bounds: the sum of the bounds of base and chirp, which need not coincide in time.

        The times of joints with a chirp are those of the chirp.
        """
        ranges = []
        for order, under in enumerate(self.base.extremes()):
            lower, upper, lower_time, upper_time = (np.array(part, float) for part in under)
            for joint, (size, when) in zip(self.joints, self._reached, strict=True):
                lower[joint], upper[joint] = lower[joint] - size[order], upper[joint] + size[order]
                lower_time[joint] = upper_time[joint] = self.begin + when[order]
            ranges.append(Range(lower, upper, lower_time, upper_time))
        return Extremes(*ranges)

    def frequency(self, time: np.ndarray) -> np.ndarray:
        """Frequency at times during the chirp, shape (t,) [Hz]."""
        return self._waves[0].frequency(np.asarray(time, float) - self.begin)

    def amplitude(self, frequency: np.ndarray) -> np.ndarray:
        """Amplitude of each joint's chirp at frequencies of shape (f,) [Hz]; shape (f, k) [rad]."""
        return np.stack([wave.amplitude(np.asarray(frequency, float)) for wave in self._waves], axis=1)

    def scaled(self, share: float) -> "Chirp":
        """This chirp with every amplitude multiplied by a share."""
        return replace(self, largest=share * self.largest)

    @property
    def reached(self) -> np.ndarray:
        """Bounds of the absolute values of each joint's chirp alone, position to jerk, shape (k, 4)."""
        return np.array([size for size, _ in self._reached])

    @cached_property
    def _reached(self) -> list[tuple[np.ndarray, np.ndarray]]:
        return [wave.reached() for wave in self._waves]

    @property
    def _waves(self) -> list[ChirpWave]:
        shared = (self.low, self.high, self.length, self.fade, self.logarithmic)
        return [ChirpWave(*shared, largest) for largest in self.largest]
