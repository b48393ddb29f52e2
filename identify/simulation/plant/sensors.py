"""Sensors: what encoders, current sensors and thermometers make of the truth."""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, pi, sqrt

import numpy as np

from .steps import compiled, fading

FINEST = 1e-12
"""What a step of zero is beside others that are not."""


@dataclass(frozen=True, eq=False)
class Sensors:
    """Resolution and noise; zero for none of it.

    Attributes:
        encoder_step: Resolution of the motor encoder, seen from the joint, shape (n,) [rad].
        encoder_noise: Standard deviation of its white noise, shape (n,) [rad].
        current_step: Resolution of the current, shape (n,) [A].
        current_noise: Standard deviation of its white noise, shape (n,) [A].
        current_drift: Standard deviation of its noise that lasts, shape (n,) [A].
        drift_time: How long that lasts: time after which 37 % of it is left [s].
        velocity_cutoff: Cut-off of the low-pass that the drive puts behind differences of position [Hz].
        temperature_step: [K].
        current_delay: By how much currents are older than the positions they come with, one number or shape
            (n,) [s]; below zero, positions are older.
        current_limit: Largest current that is shown, one number or shape (n,) [A].
    """

    encoder_step: np.ndarray
    encoder_noise: np.ndarray
    current_step: np.ndarray
    current_noise: np.ndarray
    current_drift: np.ndarray
    drift_time: float = 0.01
    velocity_cutoff: float = 100.0
    temperature_step: float = 0.1
    current_delay: float | np.ndarray = 0.0
    current_limit: float | np.ndarray = np.inf

    @classmethod
    def exact(cls, joints: int, current_delay: float = 0.0) -> "Sensors":
        """Sensors that add nothing."""
        none = np.zeros(joints)
        return cls(none, none, none, none, none, temperature_step=0.0, current_delay=current_delay)


class Past:
    """What sensors that are late have yet to show.

    Args:
        delay: Delay of each number, shape (k,) [s].
        values: What has been so far, shape (k,).
    """

    def __init__(self, delay: np.ndarray, values: np.ndarray) -> None:
        self._delay, self._longest, self._ages, self._values = delay, float(np.max(delay)), [0.0], [values]

    @property
    def newest(self) -> np.ndarray:
        """What is now, shape (k,)."""
        return self._values[-1]

    def add(self, values: np.ndarray, seconds: float) -> None:
        """Some time has gone by."""
        self._ages = [*(age + seconds for age in self._ages), 0.0]
        self._values.append(values)
        while len(self._ages) > 1 and self._ages[1] >= self._longest:
            del self._ages[0], self._values[0]

    def delayed(self) -> np.ndarray:
        """What is shown, shape (k,), between moments that are remembered."""
        if len(self._ages) == 1:
            return self._values[0]
        ages, values = np.negative(self._ages), np.array(self._values).T
        pairs = zip(self._delay, values, strict=True)
        return np.array([np.interp(-delay, ages, own) for delay, own in pairs])


class Readings:
    """Sensors at work, with all that they remember. Every tick draws the same count of random numbers.

    Args:
        sensors: What they are.
        position: At the start, shape (n,) [rad].
        current: At the start, shape (n,) [A].
        seed: Seed of the noise.

    Attributes:
        position: As last measured, shape (n,) [rad]; so `velocity` [rad/s] and `current` [A].
    """

    def __init__(self, sensors: Sensors, position: np.ndarray, current: np.ndarray, seed: int) -> None:
        self._sensors, self._random, self._fading = sensors, np.random.default_rng(seed), compiled(fading)
        self._quiet = not np.any((sensors.encoder_noise, sensors.current_noise, sensors.current_drift))
        n = len(position)
        self._counts = _rounding(sensors.encoder_step)
        self._samples = _rounding(sensors.current_step)
        self.warmth = _rounding(np.full(n, sensors.temperature_step))
        white = self._random.normal(size=(3, n))
        self._drift = sensors.current_drift * white[0]
        self.position, self.velocity = self._counts(position + sensors.encoder_noise * white[1]), np.zeros(n)
        self.current = self._current(current + self._drift + sensors.current_noise * white[2])
        self._fading(0.0, self._drift, white)  # does not count, but compiles it: not in a tick of real time

    def see(
        self, position: np.ndarray, current: np.ndarray, seconds: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Position [rad], velocity [rad/s] and current [A], each (t, n), of what is so some seconds apart."""
        sensors, fading = self._sensors, self._fading
        if not self._quiet:
            white = self._random.normal(size=(len(position), 3, position.shape[1]))
            share = exp(-seconds / sensors.drift_time)
            drift = fading(share, self._drift, sqrt(1.0 - share**2) * sensors.current_drift * white[:, 1])
            position = position + sensors.encoder_noise * white[:, 0]
            current = current + drift + sensors.current_noise * white[:, 2]
            self._drift = drift[-1]
        position, current = self._counts(position), self._current(current)
        before = np.concatenate([self.position[None], position[:-1]])
        share = exp(-2 * pi * sensors.velocity_cutoff * seconds)
        velocity = fading(share, self.velocity, (1.0 - share) / seconds * (position - before))
        self.position, self.velocity, self.current = position[-1], velocity[-1], current[-1]
        return position, velocity, current

    def _current(self, current: np.ndarray) -> np.ndarray:
        """What the sensor shows of a current, any shape [A]."""
        limit = self._sensors.current_limit
        return np.clip(self._samples(current), -limit, limit)


def _rounding(step: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Function that rounds to multiples of steps (n,), where they are not zero."""
    if not np.any(step):
        return lambda value: value
    fine = np.where(step == 0.0, FINEST, step)
    return lambda value: np.rint(value / fine) * fine
