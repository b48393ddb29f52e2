"""Transports: hand frames to a CAN adapter and take frames from it.

python-can makes an object of every frame, checks, filters and logs it. For the frames of six joints this
takes longer than all other work of a cycle. Where python-can has a socket or a serial port, it is used
directly; all other interfaces go through python-can, by `PythonCanTransport`.
"""

import os
import select
import socket
import struct
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import can

from ..host_clock import Pause

Frame = tuple[int, bytes]
"""Identifier and data. Flags above the identifier's bits mark all that is not a classic frame of data with an
11-bit identifier."""

EXTENDED, REMOTE, ERROR = 1 << 31, 1 << 30, 1 << 29
"""Flags in an identifier: of 29 bits, a remote frame, an error frame (as in Linux, can.h)."""
FD = 1 << 32
"""Flag in an identifier: a frame of CAN FD."""
STANDARD = 0x7FF
"""Largest identifier of 11 bits; with a flag the number is larger."""
IDENTIFIER = 0x1FFFFFFF
"""Bits of an identifier, without flags."""


class Transport(ABC):
    """Frames to an adapter and from it; what the adapter or the system raises is raised.

    Attributes:
        pause: Looked at right before frames are handed over; after a pause none is.
    """

    pause = Pause(float("inf"))

    @abstractmethod
    def send(self, frames: Sequence[Frame], timeout: float) -> None:
        """Hand frames over, all within a time-out [s]; after one that fails the others are tried."""

    @abstractmethod
    def receive(self, timeout: float) -> Frame | None:
        """The next frame, waited for so long [s], or None. Raises ValueError for what is none, and others."""

    def close(self) -> None:  # noqa: B027 - most have nothing of their own
        """Let go of what is its own; the bus is closed by python-can."""


FLOOD = 500
"""Frames that are passed over at most in one call."""


class PythonCanTransport(Transport):
    """Any interface, by the methods that python-can gives all of them."""

    def __init__(self, bus: can.BusABC) -> None:
        self._bus = bus

    def send(self, frames: Sequence[Frame], timeout: float) -> None:
        end = time.monotonic() + timeout

        def send(identifier: int, data: bytes) -> None:
            self._bus.send(message(identifier, data), max(end - time.monotonic(), 0.0))

        send_each(frames, send, self.pause)

    def receive(self, timeout: float) -> Frame | None:
        """As in `Transport`; some interfaces return what was sent, which is passed over."""
        end = time.monotonic() + timeout
        for _ in range(FLOOD):
            received = self._bus.recv(max(end - time.monotonic(), 0.0))
            if received is None:
                return None
            if received.is_rx:
                return flagged(received), bytes(received.data)
        return None

    def close(self) -> None:
        pass


def send_each(frames: Sequence[Frame], send: Callable[[int, bytes], None], pause: Pause) -> None:
    """Send every frame, also after one that fails, and none after a pause; the first failure is raised."""
    failure: Exception | None = None
    for identifier, data in frames:
        if pause.noticed():
            return
        try:
            send(identifier, data)
        except Exception as error:  # each of python-can's interfaces has errors of its own
            failure = failure or error
    if failure is not None:
        raise failure


def message(identifier: int, data: bytes) -> can.Message:
    """A frame as python-can's object; the identifier with its flags."""
    return can.Message(
        arbitration_id=identifier & IDENTIFIER,
        is_extended_id=bool(identifier & EXTENDED),
        is_remote_frame=bool(identifier & REMOTE),
        is_error_frame=bool(identifier & ERROR),
        is_fd=bool(identifier & FD),
        data=data,
    )


def flagged(received: can.Message) -> int:
    """Identifier of python-can's object, with its flags."""
    return (
        received.arbitration_id
        | EXTENDED * received.is_extended_id
        | REMOTE * received.is_remote_frame
        | ERROR * received.is_error_frame
        | FD * received.is_fd
    )


READ = 4096
"""Bytes that are read at once."""
LONGEST_LINE = 1 << 16
"""Bytes without the end of a line after which they are thrown away: no adapter sends such a line."""
KINDS = {
    "t": (3, 0), "T": (8, EXTENDED), "x": (8, EXTENDED), "r": (3, REMOTE), "R": (8, EXTENDED | REMOTE),
    "d": (3, FD), "b": (3, FD), "D": (8, EXTENDED | FD), "B": (8, EXTENDED | FD),
}  # fmt: skip
"""First letter of a line -> digits of the identifier, and its flags; other lines answer what was sent."""


class SlcanTransport(Transport):
    """An adapter on a serial port, of which python-can's has the file descriptor of POSIX systems."""

    def __init__(self, port: Any) -> None:
        self._waited_for = [port.fd]
        self._text, self._lines, self._unsent = b"", deque[bytes](), b""

    def send(self, frames: Sequence[Frame], timeout: float) -> None:
        """Write all lines at once. If the port takes only a part of a line, the next call completes it."""
        if self.pause.noticed():
            return
        lines = [f"t{identifier:03X}{len(data)}{data.hex().upper()}\r" for identifier, data in frames]
        text, sent, end = self._unsent + "".join(lines).encode(), 0, time.monotonic() + timeout
        while (
            sent < len(text) and select.select([], self._waited_for, [], max(end - time.monotonic(), 0.0))[1]
        ):
            sent += os.write(self._waited_for[0], text[sent:])
        inside_line = text[sent - 1] != ord("\r") if sent else bool(self._unsent)
        self._unsent = text[sent : text.find(b"\r", sent) + 1] if inside_line else b""
        if sent < len(text):
            raise OSError("the adapter does not take what it is sent")

    def receive(self, timeout: float) -> Frame | None:
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
        pass

    def _read(self) -> None:
        data = os.read(self._waited_for[0], READ)
        if not data:
            raise OSError("the adapter is gone")
        *lines, self._text = (self._text + data.replace(b"\a", b"\r")).split(b"\r")
        self._lines.extend(lines)
        if len(self._text) > LONGEST_LINE:
            self._text = b""


def _frame(line: str) -> Frame | None:
    """The frame in a line; None for a line that has none. Raises ValueError for a broken line."""
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


LONGEST = 400
"""Bytes of a datagram that are read: more than any has. Python has objects of up to 512 bytes quickly."""


class SocketTransport(Transport):
    """Frames over an open socket, which stays python-can's and is not closed here."""

    def __init__(self, link: socket.socket) -> None:
        self._socket, self._waited_for = link, [link.fileno()]

    @abstractmethod
    def _encode(self, identifier: int, data: bytes) -> bytes:
        """The datagram of a frame of data with an 11-bit identifier."""

    @abstractmethod
    def _decode(self, datagram: bytes) -> Frame | None:
        """The frame in a datagram; None to pass it over. Raises ValueError, KeyError, TypeError for none."""

    @abstractmethod
    def _hand_over(self, datagram: bytes) -> None:
        """Give a datagram to the socket without waiting. Raises BlockingIOError if it is not taken now."""

    def send(self, frames: Sequence[Frame], timeout: float) -> None:

        end = time.monotonic() + timeout

        def send(identifier: int, data: bytes) -> None:
            datagram = self._encode(identifier, data)
            try:
                self._hand_over(datagram)
            except BlockingIOError:
                select.select([], self._waited_for, [], max(end - time.monotonic(), 0.0))
                self._hand_over(datagram)

        send_each(frames, send, self.pause)

    def receive(self, timeout: float) -> Frame | None:
        if timeout > 0.0 and not select.select(self._waited_for, [], [], timeout)[0]:
            return None
        for _ in range(FLOOD):
            try:
                datagram = self._socket.recv(LONGEST, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return None
            frame = self._decode(datagram)
            if frame is not None:
                return frame
        return None


FRAME = struct.Struct("=IB2xB8s")
"""`can_frame` of Linux: identifier with flags, number of bytes, the same as its code, eight bytes of data."""
HEAD = struct.Struct("=I")
"""What a frame of CAN FD begins with, likewise."""
LARGEST_FD = 72
"""Size of `canfd_frame` [bytes]."""


class SocketcanTransport(SocketTransport):
    """A SocketCAN interface; its flags of identifiers are those of `transport`."""

    def _encode(self, identifier: int, data: bytes) -> bytes:
        return FRAME.pack(identifier, len(data), len(data), data)

    def _decode(self, datagram: bytes) -> Frame:
        if len(datagram) == LARGEST_FD:
            return (HEAD.unpack_from(datagram)[0] & IDENTIFIER) | FD, b""
        if len(datagram) != FRAME.size:
            raise ValueError(f"a frame of {len(datagram)} bytes")
        identifier, length, _, data = FRAME.unpack(datagram)
        return identifier, data[:length]

    def _hand_over(self, datagram: bytes) -> None:
        self._socket.send(datagram, socket.MSG_DONTWAIT)


def transport_of(bus: can.BusABC, interface: str, channel: str, options: Mapping[str, Any]) -> Transport:
    """The quickest transport that an open bus allows, by the interface, channel and options of python-can."""
    link = getattr(bus, "socket", None)
    if interface == "socketcan" and channel and isinstance(link, socket.socket):
        return SocketcanTransport(link)
    if interface == "slcan" and hasattr(port := getattr(bus, "serialPortOrig", None), "fd"):
        return SlcanTransport(port)
    if interface == "udp_multicast" and os.name == "posix":
        from .udp_multicast import UdpMulticastTransport

        return UdpMulticastTransport(bus.fileno(), channel, options.get("port"))
    return PythonCanTransport(bus)
