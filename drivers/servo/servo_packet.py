"""What the packets of all servos on a line have in common."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol


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
