"""Sensors: errors of encoders, current sensors and thermometers."""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, pi, sqrt

import numpy as np
from scipy.signal import lfilter

FINEST = 1e-12
"""Resolution of a sensor without rounding, if other joints have rounding."""


@dataclass(frozen=True, eq=False)
class Sensors:
    """Resolution and noise of the sensors; zero for none."""

    encoder_step: np.ndarray  # resolution of the motor encoder on the joint side, shape (n,) [rad]
    encoder_noise: np.ndarray  # standard deviation of the white encoder noise, shape (n,) [rad]
    current_step: np.ndarray  # resolution of the current, shape (n,) [A]
    current_noise: np.ndarray  # standard deviation of the white current noise, shape (n,) [A]
    current_drift: np.ndarray  # standard deviation of the correlated current noise, shape (n,) [A]
    drift_time: float = 0.01  # correlation time of that noise, after which 37 % remain [s]
    velocity_cutoff: float = 100.0  # cut-off of the drive's low-pass filter for differences of position [Hz]
    temperature_step: float = 0.1  # resolution of the temperature [K]
    # Delay of currents behind the positions of the same sample, one number or shape (n,) [s]; if negative,
    # positions are delayed.
    current_delay: float | np.ndarray = 0.0
    current_limit: float | np.ndarray = np.inf  # maximum measurable current, one number or shape (n,) [A]

    @classmethod
    def exact(cls, joints: int, current_delay: float = 0.0) -> "Sensors":
        """Sensors without errors."""
        none = np.zeros(joints)
        return cls(none, none, none, none, none, temperature_step=0.0, current_delay=current_delay)


class Past:
    """Buffer of past values, for sensors with a delay (k,) [s] of each value, from initial values (k,)."""

    def __init__(self, delay: np.ndarray, values: np.ndarray) -> None:
        self._delay, self._longest, self._ages, self._values = delay, float(np.max(delay)), [0.0], [values]

    @property
    def newest(self) -> np.ndarray:
        """Newest values, shape (k,)."""
        return self._values[-1]

    def add(self, values: np.ndarray, seconds: float) -> None:
        """Add new values after some time [s]."""
        self._ages = [*(age + seconds for age in self._ages), 0.0]
        self._values.append(values)
        while len(self._ages) > 1 and self._ages[1] >= self._longest:
            del self._ages[0], self._values[0]

    def delayed(self) -> np.ndarray:
        """Delayed values, shape (k,), interpolated between the stored ones."""
        if len(self._ages) == 1:
            return self._values[0]
        ages, values = np.negative(self._ages), np.array(self._values).T
        pairs = zip(self._delay, values, strict=True)
        return np.array([np.interp(-delay, ages, history) for delay, history in pairs])


class Readings:
    """Sensors with their state: the last measured position, velocity and current, (n,) each [rad, rad/s, A].

    Every sample draws the same number of random numbers.
    """

    def __init__(self, sensors: Sensors, position: np.ndarray, current: np.ndarray, seed: int) -> None:
        self._sensors, self._random = sensors, np.random.default_rng(seed)
        self._quiet = not np.any((sensors.encoder_noise, sensors.current_noise, sensors.current_drift))
        n = len(position)
        self._round_position = _rounding(sensors.encoder_step)
        self._round_current = _rounding(sensors.current_step)
        self.round_temperature = _rounding(np.full(n, sensors.temperature_step))
        white = self._random.normal(size=(3, n))
        self._drift = sensors.current_drift * white[0]
        self.position = self._round_position(position + sensors.encoder_noise * white[1])
        self.velocity = np.zeros(n)
        self.current = self._current(current + self._drift + sensors.current_noise * white[2])

    def see(
        self, position: np.ndarray, current: np.ndarray, seconds: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Measured position [rad], velocity [rad/s] and current [A], each (t, n), at a period [s]."""
        sensors = self._sensors
        if not self._quiet:
            white = self._random.normal(size=(len(position), 3, position.shape[1]))
            share = exp(-seconds / sensors.drift_time)
            drift = _fading(share, self._drift, sqrt(1.0 - share**2) * sensors.current_drift * white[:, 1])
            position = position + sensors.encoder_noise * white[:, 0]
            current = current + drift + sensors.current_noise * white[:, 2]
            self._drift = drift[-1]
        position, current = self._round_position(position), self._current(current)
        before = np.concatenate([self.position[None], position[:-1]])
        share = exp(-2 * pi * sensors.velocity_cutoff * seconds)
        velocity = _fading(share, self.velocity, (1.0 - share) / seconds * (position - before))
        self.position, self.velocity, self.current = position[-1], velocity[-1], current[-1]
        return position, velocity, current

    def _current(self, current: np.ndarray) -> np.ndarray:
        """Measured current for a true current of any shape [A]."""
        limit = self._sensors.current_limit
        return np.clip(self._round_current(current), -limit, limit)


def _fading(share: float, last: np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """Sum of inputs (t, n) of which a share remains from row to row, starting with `last` (n,)."""
    return lfilter([1.0], [1.0, -share], inputs, axis=0, zi=share * last[None])[0]


def _rounding(step: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Function that rounds to multiples of the nonzero steps (n,)."""
    if not np.any(step):
        return lambda value: value
    resolution = np.where(step == 0.0, FINEST, step)
    return lambda value: np.rint(value / resolution) * resolution
