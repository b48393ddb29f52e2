"""Dynamixel protocol 2.0: packets to bytes and back.

    FF FF FD 00 | id | length (2) | instruction | parameters | CRC (2)

The length counts from the instruction on. FF FF FD never occurs after the length: byte stuffing makes it
FF FF FD FD. An answer has the instruction 55, and an error before its parameters.
"""

from collections.abc import Mapping, Sequence
from functools import cache, partial

from ..servo.servo_line import Parsed, Reading, Status

HEADER = b"\xff\xff\xfd\x00"
EVERYBODY = 0xFE
PING, STATUS, SYNC_READ, SYNC_WRITE, FAST_SYNC_READ = 0x01, 0x55, 0x82, 0x83, 0x8A
ALERT = 0x80
"""Bit of the error byte: the register of hardware errors is not zero."""

ERRORS = {
    1: "result fail: the servo could not execute the instruction",
    2: "instruction: the servo does not support it",
    3: "CRC: the servo received a wrong checksum",
    4: "data range: a value does not fit its register",
    5: "data length: fewer data than the register has",
    6: "data limit: a value is beyond the limits of its register",
    7: "access: the register cannot be read or written now",
}
"""Meanings of the error number, which is in the other bits of the error byte; 0 means no error."""

_AROUND = 11
"""Length of an answer without data [bytes]."""


def _crc_table() -> tuple[int, ...]:
    table = []
    for byte in range(256):
        remainder = byte << 8
        for _ in range(8):
            remainder = (remainder << 1) ^ (0x8005 if remainder & 0x8000 else 0)
        table.append(remainder & 0xFFFF)
    return tuple(table)


_TABLE = _crc_table()
_BEFORE = tuple((checksum << 8 & 0xFF00) ^ _TABLE[checksum >> 8] for checksum in _TABLE)
"""Checksum of each byte followed by a zero: processing two bytes at once halves the time."""


def crc(data: bytes, before: int = 0) -> int:
    """CRC with polynomial 0x8005, initial value zero, not reflected; `before` is that of preceding bytes."""
    value, odd, table, table_before = before, len(data) % 2, _TABLE, _BEFORE
    for byte in data[:odd]:
        value = (value << 8 & 0xFF00) ^ table[value >> 8 ^ byte]
    for first, second in zip(data[odd::2], data[odd + 1 :: 2], strict=True):
        value = table_before[value >> 8 ^ first] ^ table[value & 0xFF ^ second]
    return value


def packet(servo: int, instruction: int, parameters: bytes = b"") -> bytes:
    """Encode an instruction or an answer."""
    stuffed = parameters.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
    body = HEADER + bytes([servo, *(len(stuffed) + 3).to_bytes(2, "little"), instruction]) + stuffed
    return body + crc(body).to_bytes(2, "little")


def ping(servo: int) -> Reading:
    """Ask whether a servo is there; the data are its model (2 bytes) and firmware (1 byte)."""
    return Reading(packet(servo, PING), (servo,), _AROUND + 3, 3, partial(parse, length=3))


def sync_read(address: int, length: int, servos: Sequence[int]) -> Reading:
    """Ask several servos for the same registers; each answers with a packet."""
    request = packet(EVERYBODY, SYNC_READ, _registers(address, length) + bytes(servos))
    size = len(servos) * (_AROUND + length)
    return Reading(request, tuple(servos), size, length, partial(parse, length=length))


def fast_sync_read(address: int, length: int, servos: Sequence[int]) -> Reading:
    """Ask several servos for the same registers; their answers are parts of a single packet."""
    request = packet(EVERYBODY, FAST_SYNC_READ, _registers(address, length) + bytes(servos))
    size = 8 + len(servos) * (4 + length)
    parse_joined = partial(parse_fast, length=length, count=len(servos))
    return Reading(request, tuple(servos), size, length, parse_joined)


def sync_write(address: int, values: Mapping[int, bytes]) -> bytes:
    """Write the same registers of several servos, which do not answer."""
    length = len(next(iter(values.values())))
    blocks = b"".join(bytes([servo]) + value for servo, value in values.items())
    return packet(EVERYBODY, SYNC_WRITE, _registers(address, length) + blocks)


def refusal(error: int) -> str:
    """Meaning of an error byte with an error number; empty without an error number."""
    number = error & ~ALERT
    meaning = f"error {number} ({ERRORS.get(number, 'unknown')})" if number else ""
    return f"{meaning} and a hardware error" if number and error & ALERT else meaning


def parse(data: bytes, length: int) -> Parsed:
    """Find answers with this many bytes of data each; other bytes are skipped.

    An answer with an error number has no data: a servo that could not execute the instruction sends none, or
    bytes that are not measurements.
    """
    statuses: list[Status] = []
    broken, start = 0, 0
    largest = _AROUND + 4 * (length + 1) // 3
    while (start := data.find(HEADER, start)) >= 0 and len(data) >= start + _AROUND:
        size = 7 + int.from_bytes(data[start + 5 : start + 7], "little")
        if _AROUND <= size <= largest and len(data) < start + size:
            break
        status = _status(data[start : start + size], length) if _AROUND <= size <= largest else None
        if status is None:
            broken, start = broken + 1, start + 1
        else:
            statuses.append(status)
            start += size
    return Parsed(statuses, broken)


def _status(answer: bytes, length: int) -> Status | None:
    if answer[7] != STATUS or crc(answer[:-2]) != int.from_bytes(answer[-2:], "little"):
        return None
    body = answer[8:-2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
    if len(body) in (1, 1 + length) and body[0] & ~ALERT:
        return Status(answer[4], body[0], b"")
    return Status(answer[4], body[0], body[1:]) if len(body) == 1 + length else None


def parse_fast(data: bytes, length: int, count: int) -> Parsed:
    """Parse answers in a joined packet; the answers before a break are valid.

    Every servo appends the checksum of all bytes so far to its part. There is no byte stuffing.
    """
    begin, check = _begin_of_joined(length, count)
    start = data.find(begin)
    if start < 0:
        return Parsed([], count if len(data) >= len(begin) + count * (4 + length) else 0)
    statuses: list[Status] = []
    place = checked = start + len(begin)
    for _ in range(count):
        end = place + 2 + length
        part, mark = data[place:end], data[end : end + 2]
        if len(mark) < 2:
            return Parsed(statuses, 0)
        check, checked = crc(data[checked:end], check), end
        if check.to_bytes(2, "little") != mark:
            missing = count - len(statuses)
            return Parsed(statuses, missing if len(data) >= place + missing * (4 + length) else 0)
        statuses.append(Status(part[1], part[0], b"" if part[0] & ~ALERT else part[2:]))
        place = end + 2
    return Parsed(statuses, 0)


@cache
def _begin_of_joined(length: int, count: int) -> tuple[bytes, int]:
    """Bytes before the parts of joined answers, and their checksum."""
    begin = HEADER + bytes([EVERYBODY, *(1 + count * (4 + length)).to_bytes(2, "little"), STATUS])
    return begin, crc(begin)


def _registers(address: int, length: int) -> bytes:
    return address.to_bytes(2, "little") + length.to_bytes(2, "little")
