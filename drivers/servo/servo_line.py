"""Servos on a serial line: registers and packets, whether the line can carry a cycle, settings and units."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, Protocol

import numpy as np

from ..errors import BadSettings
from ..settings import setting


class Sign(Enum):
    """Representation of negative numbers in a register."""

    NONE = "no negative numbers"
    COMPLEMENT = "two's complement"
    HIGHEST_BIT = "magnitude, with the sign in the highest bit"


class Register(NamedTuple):
    """A register of a servo, with its values as bytes, the lowest first."""

    address: int  # address of its lowest byte
    size: int  # number of bytes
    name: str  # name in messages
    sign: Sign = Sign.NONE  # how it represents negative numbers

    def __str__(self) -> str:
        return f"{self.name} (register {self.address})"

    def encode(self, value: int) -> bytes:
        if self.sign is Sign.HIGHEST_BIT and value < 0:
            value = -value | self._highest_bit
        return (value & (1 << 8 * self.size) - 1).to_bytes(self.size, "little")

    def decode(self, data: bytes) -> int:
        value = int.from_bytes(data, "little", signed=self.sign is Sign.COMPLEMENT)
        if self.sign is Sign.HIGHEST_BIT and value & self._highest_bit:
            return -(value ^ self._highest_bit)
        return value

    @property
    def _highest_bit(self) -> int:
        return 1 << 8 * self.size - 1


class Status(NamedTuple):
    """One answer: id of the servo, its error byte, and the requested data, empty if it refuses."""

    servo: int
    error: int
    data: bytes


class Parsed(NamedTuple):
    """Answers in the order of arrival, and the number of broken packets."""

    statuses: list[Status]
    broken: int


@dataclass(frozen=True)
class Reading:
    """A request to servos, and how to parse their answers."""

    packet: bytes  # bytes of the request
    servos: tuple[int, ...]  # ids of the servos that answer
    answer_bytes: int  # length of all answers together without byte stuffing [bytes]
    length: int  # length of the data in each answer [bytes]
    parse: Callable[[bytes], Parsed]  # function that parses the answers


class Codec(Protocol):
    """A servo protocol, implemented by a module."""

    def ping(self, servo: int) -> Reading:
        """Ask whether a servo is there."""

    def sync_read(self, address: int, length: int, servos: Sequence[int]) -> Reading:
        """Ask several servos for the same registers."""

    def sync_write(self, address: int, values: Mapping[int, bytes]) -> bytes:
        """Write the same registers of several servos, which do not answer."""

    def refusal(self, error: int) -> str:
        """Meaning of the error byte of an answer without valid data; empty if the data are valid."""


RETURN_DELAY_UNIT = 2e-6
"""Unit of every servo's return delay [s]."""

BITS_A_BYTE = 10
"""Bits on the line per byte: a start bit, eight data bits, a stop bit."""

USABLE = 0.9
"""Fraction of the cycle that the line may take [-]; the computer needs the rest."""


class Traffic(NamedTuple):
    """What the line carries in a cycle."""

    sent: int  # number of bytes sent
    received: int  # number of bytes received
    answers: int  # number of answers that wait for a return delay
    return_delay: float = 0.0  # delay of each answer [s]
    latency: float = 0.0  # delay of the adapter [s]

    def seconds(self, baudrate: int) -> float:
        """Duration [s] at a baud rate [bit/s]."""
        wire = BITS_A_BYTE * (self.sent + self.received) / baudrate
        return wire + self.answers * self.return_delay + self.latency

    def shortest_cycle(self, baudrate: int) -> float:
        """Shortest cycle that the line can carry, rounded up to 0.1 ms [s]."""
        return math.ceil(round(self.seconds(baudrate) / USABLE * 1e4, 6)) * 1e-4

    def require_rate(self, cycle: float, baudrate: int, advice: str) -> None:
        """Raise BadSettings, with further advice, if the line cannot carry the traffic in a cycle [s]."""
        shortest = self.shortest_cycle(baudrate)
        if shortest <= cycle * (1.0 + 1e-9):
            return
        raise BadSettings(
            f"a cycle of {1e3 * cycle:g} ms is too short for this line: {self.sent} bytes out and "
            f"{self.received} back at {baudrate} bit/s, {self.answers} return delays of "
            f"{1e6 * self.return_delay:.0f} us and {1e3 * self.latency:g} ms of the adapter take "
            f"{1e3 * self.seconds(baudrate):.2f} ms, limit {USABLE:.0%} of the cycle. Try a cycle of "
            f"{shortest:.4g} s, {advice}"
        )


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
