"""Packets of servos on a serial line, and whether the line can carry the packets of a cycle."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from ..errors import BadSettings


class Register(NamedTuple):
    """A register of a servo: address of its lowest byte, size [bytes], name, and whether it is signed."""

    address: int
    size: int
    name: str
    signed: bool = False

    def __str__(self) -> str:
        return f"{self.name} (register {self.address})"


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
    """A request to servos, and how to parse their answers.

    Attributes:
        packet: Bytes of the request.
        servos: Ids of the servos that answer.
        answer_bytes: Length of all answers together without byte stuffing [bytes].
        length: Length of the data in each answer [bytes].
        parse: Function that parses the answers.
    """

    packet: bytes
    servos: tuple[int, ...]
    answer_bytes: int
    length: int
    parse: Callable[[bytes], Parsed]


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
    """Bytes sent and received in a cycle, and the number of answers that wait for a return delay."""

    sent: int
    received: int
    answers: int

    def seconds(self, baudrate: int, return_delay: float = 0.0, latency: float = 0.0) -> float:
        """Duration [s] at a baud rate [bit/s], with delays of each answer and of the adapter [s]."""
        wire = BITS_A_BYTE * (self.sent + self.received) / baudrate
        return wire + self.answers * return_delay + latency


def shortest_cycle(traffic: Traffic, baudrate: int, return_delay: float = 0.0, latency: float = 0.0) -> float:
    """Shortest cycle that the line can carry, rounded up to 0.1 ms [s]."""
    needed = traffic.seconds(baudrate, return_delay, latency) / USABLE
    return math.ceil(round(needed * 1e4, 6)) * 1e-4


def require_rate(
    traffic: Traffic, cycle: float, baudrate: int, return_delay: float, latency: float, advice: str
) -> None:
    """Raise BadSettings, with further advice, if the line cannot carry the traffic in a cycle [s]."""
    shortest = shortest_cycle(traffic, baudrate, return_delay, latency)
    if shortest <= cycle * (1.0 + 1e-9):
        return
    total = traffic.seconds(baudrate, return_delay, latency)
    raise BadSettings(
        f"a cycle of {1e3 * cycle:g} ms is too short for this line: {traffic.sent} bytes out and "
        f"{traffic.received} back at {baudrate} bit/s, {traffic.answers} return delays of "
        f"{1e6 * return_delay:.0f} us and {1e3 * latency:g} ms of the adapter take {1e3 * total:.2f} ms, "
        f"limit {USABLE:.0%} of the cycle. Try a cycle of {shortest:.4g} s, {advice}"
    )
