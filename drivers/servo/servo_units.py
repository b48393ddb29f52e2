"""Common settings of servos on a serial line, and conversion between servo counts and joint radians."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..settings import setting


@dataclass(frozen=True)
class ServoSettings:
    """Settings that all servo drivers share."""

    port: str = setting(..., 'serial port of the adapter, such as "/dev/ttyUSB0"')
    ids: tuple[int, ...] = setting(..., "id of each joint's servo", low=0, high=252)
    baudrate: int = setting(
        1_000_000, "baud rate that is set in the servos", unit="bit/s", low=9600, high=10_000_000
    )
    cycle: float = setting(0.002, "time between exchanges", unit="s", low=0.001, high=0.1)
    counts_per_turn: tuple[int, ...] = setting(4096, "counts in a turn of the servo", low=1, high=1 << 24)
    gear: tuple[float, ...] = setting(1.0, "turns of the servo in a turn of the joint", low=1e-3, high=1e4)
    sign: tuple[int, ...] = setting(1, "-1 where the servo turns against the joint", choices=(1, -1))
    zero: tuple[int, ...] = setting(
        2048, "count of the servo where the joint's position is zero", low=-(1 << 24), high=1 << 24
    )
    return_delay: float = setting(
        0.0, "how long a servo waits before it answers", unit="s", low=0.0, high=508e-6
    )
    at_end: str = setting(
        "hold", "what servos do after the run: an arm without brakes drops when off", choices=("hold", "off")
    )


def explained(settings: ServoSettings) -> dict[str, str]:
    """Settings as texts, which explain the measurements later."""
    return {
        name: " ".join(map(str, value)) if isinstance(value, tuple) else str(value)
        for name, value in vars(settings).items()
    }


class Goals(NamedTuple):
    """Range of goals that the servos accept [counts], each of shape (n,)."""

    lowest: np.ndarray
    highest: np.ndarray


class Measured(NamedTuple):
    """Measurements of the servos, each of shape (n,), with the signs of the servos.

    Position is in [counts], velocity in [rad/s], current in [A], temperature in [degC]; NaN where unknown.
    """

    position: np.ndarray
    velocity: np.ndarray
    current: np.ndarray
    temperature: np.ndarray


class ServoUnits:
    """Conversion between servo counts and joint radians; `sign` is -1 if servo and joint turn oppositely."""

    def __init__(self, settings: ServoSettings) -> None:
        turn = np.array(settings.counts_per_turn) * np.array(settings.gear)
        self.sign = np.array(settings.sign, float)
        self._gear = np.array(settings.gear)
        self._scale = self.sign * 2.0 * np.pi / turn  # (n,) [rad] a count
        self._zero = np.array(settings.zero, float)
        self._per_velocity = self.sign * self._gear

    def position(self, counts: np.ndarray) -> np.ndarray:
        """Joint positions, shape (n,) [rad], at these servo counts."""
        return (counts - self._zero) * self._scale

    def counts(self, position: np.ndarray) -> np.ndarray:
        """Servo counts nearest to joint positions [rad], shape (n,)."""
        return np.rint(self._zero + position / self._scale)

    def velocity(self, of_servos: np.ndarray) -> np.ndarray:
        """Joint velocities, shape (n,) [rad/s], from the velocities of the servos [rad/s]."""
        return of_servos / self._per_velocity

    def displacement(self, counts: np.ndarray) -> np.ndarray:
        """Displacements of joints whose servos move by these counts, shape (n,) [rad]."""
        return counts * self._scale
