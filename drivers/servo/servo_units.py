"""Units of servos: their counts, and the joints' radians."""

from typing import NamedTuple

import numpy as np

from .servo_settings import ServoSettings


class Goals(NamedTuple):
    """Counts that the servos take as a goal, each of shape (n,)."""

    lowest: np.ndarray
    highest: np.ndarray


class Measured(NamedTuple):
    """What the servos answered, each of shape (n,), with the signs of the servos.

    Attributes:
        position: [counts].
        velocity: [rad/s].
        current: [A]; NaN where there is none.
        temperature: [degC]; NaN where it was not asked for.
    """

    position: np.ndarray
    velocity: np.ndarray
    current: np.ndarray
    temperature: np.ndarray


class ServoUnits:
    """Between the servos' counts and the joints' radians.

    Args:
        settings: Scales, signs and zeros.

    Attributes:
        sign: -1 where servo and joint turn against each other, shape (n,).
    """

    def __init__(self, settings: ServoSettings) -> None:
        turn = np.array(settings.counts_per_turn) * np.array(settings.gear)
        self.sign = np.array(settings.sign, float)
        self._gear = np.array(settings.gear)
        self._scale = self.sign * 2.0 * np.pi / turn  # (n,) [rad] a count
        self._zero = np.array(settings.zero, float)
        self._per_velocity = self.sign * self._gear

    def position(self, counts: np.ndarray) -> np.ndarray:
        """Of the joints, shape (n,) [rad], where the servos stand at these counts."""
        return (counts - self._zero) * self._scale

    def counts(self, position: np.ndarray) -> np.ndarray:
        """Whole counts nearest to a position of the joints [rad], shape (n,)."""
        return np.rint(self._zero + position / self._scale)

    def velocity(self, of_servos: np.ndarray) -> np.ndarray:
        """Of the joints, shape (n,) [rad/s], from that of the servos."""
        return of_servos / self._per_velocity

    def way(self, counts: np.ndarray) -> np.ndarray:
        """How far a joint goes when its servo goes so many counts, shape (n,) [rad]."""
        return counts * self._scale
