"""slcan, CAN adapters on a serial port: frames as lines of text, many of them in one reading."""

import os
import select
import time
from collections import deque
from collections.abc import Sequence
from typing import Any

from .transport import EXTENDED, FD, REMOTE, STANDARD, Frame

READ = 4096
"""Bytes that are read at once."""
LONGEST = 1 << 16
"""Bytes without the end of a line after which they are thrown away: no adapter sends such a line."""
KINDS = {
    "t": (3, 0), "T": (8, EXTENDED), "x": (8, EXTENDED), "r": (3, REMOTE), "R": (8, EXTENDED | REMOTE),
    "d": (3, FD), "b": (3, FD), "D": (8, EXTENDED | FD), "B": (8, EXTENDED | FD),
}  # fmt: skip
"""First letter of a line -> digits of the identifier, and its flags; other lines answer what was sent."""


class SlcanTransport:
    """An adapter on a serial port.

    Args:
        port: Of python-can's bus, with the file descriptor that POSIX systems have.
    """

    def __init__(self, port: Any) -> None:
        self._port, self._waited_for = port, [port.fd]
        self._text, self._lines = b"", deque[bytes]()

    def send(self, frames: Sequence[Frame], timeout: float) -> None:
        """As in `Transport`, in one writing; the time-out is that of the port."""
        lines = [f"t{identifier:03X}{len(data)}{data.hex().upper()}\r" for identifier, data in frames]
        self._port.write("".join(lines).encode())

    def receive(self, timeout: float) -> Frame | None:
        """As in `Transport`."""
        end = time.monotonic() + timeout
        while True:
            while self._lines:
                frame = _frame(self._lines.popleft().decode("ascii"))
                if frame is not None:
                    return frame
            if not select.select(self._waited_for, [], [], max(end - time.monotonic(), 0.0))[0]:
                return None
            self._read()

    def close(self) -> None:
        """As in `Transport`."""

    def _read(self) -> None:
        data = os.read(self._waited_for[0], READ)
        if not data:
            raise OSError("the adapter is gone")
        *lines, self._text = (self._text + data.replace(b"\a", b"\r")).split(b"\r")
        self._lines.extend(lines)
        if len(self._text) > LONGEST:
            self._text = b""


def _frame(line: str) -> Frame | None:
    """The frame in a line; None for a line that has none.

    Raises:
        ValueError: A line that is broken.
    """
    if line[:1] not in KINDS:
        return None
    digits, flags = KINDS[line[0]]
    identifier, length = int(line[1 : 1 + digits], 16), int(line[1 + digits : 2 + digits])
    data = bytes.fromhex(line[2 + digits : 2 + digits + 2 * length])
    if flags:
        return identifier | flags, data
    if length > 8 or len(data) != length or identifier > STANDARD:
        raise ValueError(f"a frame of {len(data)} bytes instead of {length}")
    return identifier, data
