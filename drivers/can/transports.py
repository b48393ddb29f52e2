"""Transports: send frames to a CAN adapter and receive frames from it.

python-can creates an object for every frame, checks, filters and logs it. For the frames of six joints, this
takes longer than all other work of a cycle. Where python-can has a socket or a serial port, these transports
use it directly; all other interfaces go through `PythonCanTransport`.
"""

import os
import socket
import struct
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import can

from ..host_clock import HOST, Clock, Pause

Frame = tuple[int, bytes]
"""Identifier and data. Flags above the bits of the identifier mark every frame that is not a classic data
frame with an 11-bit identifier."""

EXTENDED, REMOTE, ERROR = 1 << 31, 1 << 30, 1 << 29
"""Flags in an identifier: 29-bit identifier, remote frame, error frame (as in Linux, can.h)."""
FD = 1 << 32
"""Flag in an identifier: a frame of CAN FD."""
STANDARD = 0x7FF
"""Largest identifier of 11 bits; with a flag the number is larger."""
IDENTIFIER = 0x1FFFFFFF
"""Bits of an identifier, without flags."""


class Transport(ABC):
    """Sends frames to an adapter and receives frames; errors of the adapter or the system are passed on.

    Attributes:
        pause: Pause of the host, checked right before sending; after a pause, no frame is sent.
        clock: Clock of the host.
    """

    pause = Pause(float("inf"))
    clock: Clock = HOST

    @abstractmethod
    def send(self, frames: Sequence[Frame], timeout: float) -> None:
        """Send frames, all within a timeout [s]; if one fails, the others are still tried."""

    @abstractmethod
    def receive(self, timeout: float) -> Frame | None:
        """Return the next frame, or None after a timeout [s].

        Raises ValueError for invalid data, and errors of the adapter or the system.
        """

    def close(self) -> None:  # noqa: B027 - most have nothing to release
        """Release the resources of the transport; python-can closes the bus."""


FLOOD = 500
"""Maximum number of frames skipped in one call."""


class PythonCanTransport(Transport):
    """Any interface, through the common methods of python-can."""

    def __init__(self, bus: can.BusABC) -> None:
        self._bus = bus

    def send(self, frames: Sequence[Frame], timeout: float) -> None:
        end = self.clock.monotonic() + timeout

        def send(identifier: int, data: bytes) -> None:
            self._bus.send(message(identifier, data), max(end - self.clock.monotonic(), 0.0))

        send_each(frames, send, self.pause)

    def receive(self, timeout: float) -> Frame | None:
        """Receive as in `Transport`; frames that an interface returns to their sender are skipped."""
        end = self.clock.monotonic() + timeout
        for _ in range(FLOOD):
            received = self._bus.recv(max(end - self.clock.monotonic(), 0.0))
            if received is None:
                return None
            if received.is_rx:
                return flagged(received), bytes(received.data)
        return None

    def close(self) -> None:
        pass


def send_each(frames: Sequence[Frame], send: Callable[[int, bytes], None], pause: Pause) -> None:
    """Send every frame, even after a failure, but none after a pause. Raises the first failure."""
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
    """Convert a frame, its identifier with flags, to a message of python-can."""
    return can.Message(
        arbitration_id=identifier & IDENTIFIER,
        is_extended_id=bool(identifier & EXTENDED),
        is_remote_frame=bool(identifier & REMOTE),
        is_error_frame=bool(identifier & ERROR),
        is_fd=bool(identifier & FD),
        data=data,
    )


def flagged(received: can.Message) -> int:
    """Identifier of a message of python-can, with flags."""
    return (
        received.arbitration_id
        | EXTENDED * received.is_extended_id
        | REMOTE * received.is_remote_frame
        | ERROR * received.is_error_frame
        | FD * received.is_fd
    )


READ = 4096
"""Maximum number of bytes read at once."""
LONGEST_LINE = 1 << 16
"""Maximum length of a line [bytes]; longer input is discarded, because no adapter sends such a line."""
KINDS = {
    "t": (3, 0), "T": (8, EXTENDED), "x": (8, EXTENDED), "r": (3, REMOTE), "R": (8, EXTENDED | REMOTE),
    "d": (3, FD), "b": (3, FD), "D": (8, EXTENDED | FD), "B": (8, EXTENDED | FD),
}  # fmt: skip
"""First letter of a line -> number of digits of the identifier, and its flags; other lines are replies."""


class SlcanTransport(Transport):
    """An adapter on a serial port of python-can that has a POSIX file descriptor."""

    def __init__(self, port: Any) -> None:
        self._waited_for = [port.fd]
        self._text, self._lines, self._unsent = b"", deque[bytes](), b""

    def send(self, frames: Sequence[Frame], timeout: float) -> None:
        """Write all lines at once. If the port takes only a part of a line, the next call completes it."""
        if self.pause.noticed():
            return
        lines = [f"t{identifier:03X}{len(data)}{data.hex().upper()}\r" for identifier, data in frames]
        text, sent, end = self._unsent + "".join(lines).encode(), 0, self.clock.monotonic() + timeout
        while sent < len(text) and self.clock.writable(
            self._waited_for, max(end - self.clock.monotonic(), 0.0)
        ):
            sent += os.write(self._waited_for[0], text[sent:])
        inside_line = text[sent - 1] != ord("\r") if sent else bool(self._unsent)
        self._unsent = text[sent : text.find(b"\r", sent) + 1] if inside_line else b""
        if sent < len(text):
            raise OSError("the adapter does not take the frames")

    def receive(self, timeout: float) -> Frame | None:
        end = self.clock.monotonic() + timeout
        while True:
            while self._lines:
                frame = _frame(self._lines.popleft().decode("ascii"))
                if frame is not None:
                    return frame
            if not self.clock.readable(self._waited_for, max(end - self.clock.monotonic(), 0.0)):
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
    """Parse the frame in a line; None for a line without a frame. Raises ValueError for a broken line."""
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
"""Bytes to read of a datagram: more than any has; Python allocates objects of up to 512 bytes quickly."""


class SocketTransport(Transport):
    """Frames over an open socket, which belongs to python-can and is not closed here."""

    def __init__(self, link: socket.socket) -> None:
        self._socket, self._waited_for = link, [link.fileno()]

    @abstractmethod
    def _encode(self, identifier: int, data: bytes) -> bytes:
        """Encode a data frame with an 11-bit identifier as a datagram."""

    @abstractmethod
    def _decode(self, datagram: bytes) -> Frame | None:
        """Decode a datagram; None to skip it. Raises ValueError, KeyError or TypeError if it is no frame."""

    @abstractmethod
    def _hand_over(self, datagram: bytes) -> None:
        """Send a datagram without waiting. Raises BlockingIOError if the socket cannot take it now."""

    def send(self, frames: Sequence[Frame], timeout: float) -> None:

        end = self.clock.monotonic() + timeout

        def send(identifier: int, data: bytes) -> None:
            datagram = self._encode(identifier, data)
            try:
                self._hand_over(datagram)
            except BlockingIOError:
                self.clock.writable(self._waited_for, max(end - self.clock.monotonic(), 0.0))
                self._hand_over(datagram)

        send_each(frames, send, self.pause)

    def receive(self, timeout: float) -> Frame | None:
        if timeout > 0.0 and not self.clock.readable(self._waited_for, timeout):
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
"""`can_frame` of Linux: identifier with flags, number of bytes, its DLC code, eight data bytes."""
HEAD = struct.Struct("=I")
"""Beginning of `canfd_frame`: identifier with flags."""
LARGEST_FD = 72
"""Size of `canfd_frame` [bytes]."""


class SocketcanTransport(SocketTransport):
    """A SocketCAN interface, whose identifier flags are those of this module."""

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
    """Fastest transport for an open bus, chosen by the interface, channel and options of python-can."""
    link = getattr(bus, "socket", None)
    if interface == "socketcan" and channel and isinstance(link, socket.socket):
        return SocketcanTransport(link)
    if interface == "slcan" and hasattr(port := getattr(bus, "serialPortOrig", None), "fd"):
        return SlcanTransport(port)
    if interface == "udp_multicast" and os.name == "posix":
        from .udp_multicast import UdpMulticastTransport

        return UdpMulticastTransport(bus.fileno(), channel, options.get("port"))
    return PythonCanTransport(bus)
