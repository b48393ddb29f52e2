"""Packets of servos on a serial line, and whether the line can carry those of a cycle."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from ..errors import BadSettings


class Register(NamedTuple):
    """A number in a servo: address of its lowest byte, size [bytes], name, and whether it can be negative."""

    address: int
    size: int
    name: str
    signed: bool = False

    def __str__(self) -> str:
        return f"{self.name} (register {self.address})"


class Status(NamedTuple):
    """One answer: id of the servo, its error byte, and the data that were asked for; none if it refuses."""

    servo: int
    error: int
    data: bytes


class Parsed(NamedTuple):
    """Answers in the order in which they came, and the number of packets that were begun and are broken."""

    statuses: list[Status]
    broken: int


@dataclass(frozen=True)
class Reading:
    """A request to servos, and how their answers are found in what comes.

    `answer_bytes` is the length of all answers together, where no byte needs stuffing; `length` is that of
    the data in each.
    """

    packet: bytes
    servos: tuple[int, ...]
    answer_bytes: int
    length: int
    parse: Callable[[bytes], Parsed]


class Codec(Protocol):
    """A protocol: its module is one."""

    def ping(self, servo: int) -> Reading:
        """Is this one there?"""

    def sync_read(self, address: int, length: int, servos: Sequence[int]) -> Reading:
        """Ask several servos for the same registers."""

    def sync_write(self, address: int, values: Mapping[int, bytes]) -> bytes:
        """Write the same registers, of the same length, of several servos, which do not answer."""

    def refusal(self, error: int) -> str:
        """Meaning of an error byte of an answer without valid data; empty where the data are valid."""


RETURN_DELAY_UNIT = 2e-6
"""[s] a count of every servo's return delay."""

BITS_A_BYTE = 10
"""A start bit, eight bits, a stop bit."""

USABLE = 0.9
"""Share of the cycle that the line may take; the rest is the computer's."""


class Traffic(NamedTuple):
    """Bytes sent and received in a cycle, and the number of answers that wait for a return delay."""

    sent: int
    received: int
    answers: int

    def seconds(self, baudrate: int, return_delay: float = 0.0, latency: float = 0.0) -> float:
        """How long it takes [s], at a baudrate [bit/s], with delays of each answer and of the adapter [s]."""
        wire = BITS_A_BYTE * (self.sent + self.received) / baudrate
        return wire + self.answers * return_delay + latency


def shortest_cycle(traffic: Traffic, baudrate: int, return_delay: float = 0.0, latency: float = 0.0) -> float:
    """The shortest cycle that the line can carry, in tenths of a millisecond [s]."""
    needed = traffic.seconds(baudrate, return_delay, latency) / USABLE
    return math.ceil(round(needed * 1e4, 6)) * 1e-4


def require_rate(
    traffic: Traffic, cycle: float, baudrate: int, return_delay: float, latency: float, advice: str
) -> None:
    """Raise BadSettings where the line cannot carry it in a cycle [s], with advice what else to try."""
    shortest = shortest_cycle(traffic, baudrate, return_delay, latency)
    if shortest <= cycle * (1.0 + 1e-9):
        return
    total = traffic.seconds(baudrate, return_delay, latency)
    raise BadSettings(
        f"a cycle of {1e3 * cycle:g} ms is too short for this line: {traffic.sent} bytes out and "
        f"{traffic.received} back at {baudrate} bit/s, {traffic.answers} return delays of "
        f"{1e6 * return_delay:.0f} us and {1e3 * latency:g} ms of the adapter take {1e3 * total:.2f} ms, and "
        f"{USABLE:.0%} of the cycle can be used. Try a cycle of {shortest:.4g} s, {advice}"
    )
