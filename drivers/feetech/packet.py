"""Feetech's protocol of STS and SMS servos: packets to bytes and back.

    FF FF | id | length | instruction | parameters | checksum

The length counts from the instruction on. The checksum is the inverted sum of all bytes after the header. An
answer has its error in place of the instruction. There is no byte stuffing: FF FF can occur in the data.
"""

from collections.abc import Mapping, Sequence
from functools import partial

from ..servo.servo_line import Parsed, Reading, Status

HEADER = b"\xff\xff"
EVERYBODY = 0xFE
PING, SYNC_READ, SYNC_WRITE = 0x01, 0x82, 0x83

_AROUND = 6
"""Length of an answer without data [bytes]."""


def checksum(body: bytes) -> int:
    """Checksum of all bytes after the header."""
    return ~sum(body) & 0xFF


def packet(servo: int, instruction: int, parameters: bytes = b"") -> bytes:
    """Encode an instruction, or an answer with its error in place of the instruction."""
    body = bytes([servo, len(parameters) + 2, instruction]) + parameters
    return HEADER + body + bytes([checksum(body)])


def ping(servo: int) -> Reading:
    """Ask whether a servo is there; the answer has no data."""
    return Reading(packet(servo, PING), (servo,), _AROUND, 0, partial(parse, length=0))


def sync_read(address: int, length: int, servos: Sequence[int]) -> Reading:
    """Ask several servos for the same registers; each answers with a packet."""
    request = packet(EVERYBODY, SYNC_READ, bytes([address, length, *servos]))
    size = len(servos) * (_AROUND + length)
    return Reading(request, tuple(servos), size, length, partial(parse, length=length))


def sync_write(address: int, values: Mapping[int, bytes]) -> bytes:
    """Write the same registers of several servos, which do not answer."""
    length = len(next(iter(values.values())))
    blocks = b"".join(bytes([servo]) + value for servo, value in values.items())
    return packet(EVERYBODY, SYNC_WRITE, bytes([address, length]) + blocks)


def refusal(error: int) -> str:
    """Empty: the error bits are alarms, and the data of such an answer are valid measurements."""
    return ""


def parse(data: bytes, length: int) -> Parsed:
    """Parse answers with `length` bytes of data each; other bytes are skipped."""
    statuses: list[Status] = []
    broken, start, size = 0, 0, _AROUND + length
    while (start := data.find(HEADER, start)) >= 0 and len(data) >= start + size:
        body = data[start + 2 : start + size]
        if body[0] < EVERYBODY and body[1] == length + 2 and body[-1] == checksum(body[:-1]):
            statuses.append(Status(body[0], body[2], body[3:-1]))
            start += size
        else:
            broken, start = broken + 1, start + 1
    return Parsed(statuses, broken)
