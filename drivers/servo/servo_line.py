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
