"""Packets of servos on a serial line, and whether the line can carry those of a cycle."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from ..errors import BadSettings


class Register(NamedTuple):
    """Where a servo keeps a number.

    Attributes:
        address: Of its lowest byte.
        size: Number of bytes.
        name: What people call it.
        signed: Whether it can be negative.
    """

    address: int
    size: int
    name: str
    signed: bool = False

    def __str__(self) -> str:
        return f"{self.name} (register {self.address})"


class Status(NamedTuple):
    """One answer of one servo.

    Attributes:
        servo: Its id.
        error: Its error byte.
        data: What was asked for.
    """

    servo: int
    error: int
    data: bytes


class Parsed(NamedTuple):
    """What a stretch of bytes contains.

    Attributes:
        statuses: In the order in which they came.
        broken: Packets that were begun and are not what they should be.
    """

    statuses: list[Status]
    broken: int


@dataclass(frozen=True)
class Reading:
    """A request and what should come of it.

    Attributes:
        packet: The request.
        servos: Ids that answer, in this order.
        answer_bytes: Length of all answers together, where no byte needs stuffing.
        length: Of the data in each answer [bytes].
        parse: Finds the answers in what came.
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


BITS_A_BYTE = 10
"""A start bit, eight bits, a stop bit."""

USABLE = 0.9
"""Share of the cycle that the line may take; the rest is the computer's."""


class Traffic(NamedTuple):
    """What goes over the line in a cycle.

    Attributes:
        sent: By the computer [bytes].
        received: From the servos [bytes].
        answers: Servos that wait their return delay before they send.
    """

    sent: int
    received: int
    answers: int

    def seconds(self, baudrate: int, return_delay: float = 0.0, latency: float = 0.0) -> float:
        """How long it takes [s].

        Args:
            baudrate: [bit/s].
            return_delay: Of each servo [s].
            latency: Of the adapter [s].
        """
        wire = BITS_A_BYTE * (self.sent + self.received) / baudrate
        return wire + self.answers * return_delay + latency


def shortest_cycle(traffic: Traffic, baudrate: int, return_delay: float = 0.0, latency: float = 0.0) -> float:
    """The shortest cycle that the line can carry, in tenths of a millisecond [s]."""
    needed = traffic.seconds(baudrate, return_delay, latency) / USABLE
    return math.ceil(round(needed * 1e4, 6)) * 1e-4


def require_rate(
    traffic: Traffic, cycle: float, baudrate: int, return_delay: float, latency: float, advice: str
) -> None:
    """Nothing, if the line can carry it.

    Args:
        traffic: Of a cycle.
        cycle: [s].
        baudrate: [bit/s].
        return_delay: Of each servo [s].
        latency: Of the adapter [s].
        advice: What else to try.

    Raises:
        BadSettings: It cannot.
    """
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
