"""Transports: send frames to a CAN adapter and receive frames from it.

All interfaces go through python-can, but for an adapter on a serial port: python-can reads it byte by byte,
which takes 0.7 ms of a cycle with six joints instead of 0.03 ms, and waits without limit until the port has
taken a frame.
"""

import os
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Sequence
from typing import Any

import can

from ..host_clock import HOST, Clock, Pause

Frame = tuple[int, bytes]
"""Identifier and data."""

OTHER, ERROR = 1 << 31, 1 << 29
"""Flags in an identifier, above its bits: a frame other than a classic data frame with an 11-bit identifier,
such as one with 29 bits, a remote frame, or one of CAN FD; and an error frame of the CAN controller."""
STANDARD = 0x7FF
"""Largest identifier of 11 bits; with a flag the number is larger."""
IDENTIFIER = 0x1FFFFFFF
"""Bits of an identifier, without flags."""


class Transport(ABC):
    """Sends frames to an adapter and receives frames; errors of the adapter or the system are passed on."""

    pause = Pause(float("inf"))  # pause of the host, checked right before sending; then no frame is sent
    clock: Clock = HOST

    @abstractmethod
    def send(self, frames: Sequence[Frame], timeout: float) -> None:
        """Send frames, all within a timeout [s]; if one fails, the others are still tried."""

    @abstractmethod
    def receive(self, timeout: float) -> Frame | None:
        """Return the next frame, or None after a timeout [s].

        Raises ValueError for invalid data, and errors of the adapter or the system.
        """


FLOOD = 500
"""Maximum number of frames skipped in one call."""
WITH_SOCKET = ("socketcan", "udp_multicast")
"""Interfaces with a socket, awaited here: python-can waits by the wall clock, which may be set."""
REMEMBERED = 1000
"""Number of frames after which one that has not come back is forgotten, because it was lost."""


class PythonCanTransport(Transport):
    """Any interface, through the common methods of python-can."""

    def __init__(self, bus: can.BusABC, interface: str) -> None:
        self._bus, self._interface = bus, interface
        self._sent = deque[Frame](maxlen=REMEMBERED)  # frames that have not come back from the multicast

    def send(self, frames: Sequence[Frame], timeout: float) -> None:
        """Send every frame, even after a failure, but none after a pause. Raises the first failure."""
        end, failure = self.clock.monotonic() + timeout, None
        for frame in frames:
            if self.pause.noticed():
                return
            identifier, data = frame
            self._sent.append(frame)
            try:
                message = can.Message(arbitration_id=identifier, data=data, is_extended_id=False)
                self._bus.send(message, max(end - self.clock.monotonic(), 0.0))
            except Exception as error:  # each of python-can's interfaces has errors of its own
                failure = failure or error
        if failure is not None:
            raise failure

    def receive(self, timeout: float) -> Frame | None:
        """Receive as in `Transport`; frames that an interface returns to their sender are skipped."""
        if timeout > 0.0 and self._interface in WITH_SOCKET:
            if not self.clock.readable([self._bus.fileno()], timeout):
                return None
            timeout = 0.0
        end = self.clock.monotonic() + timeout
        for _ in range(FLOOD):
            received = self._bus.recv(max(end - self.clock.monotonic(), 0.0))
            if received is None:
                return None
            other = received.is_extended_id or received.is_remote_frame or received.is_fd
            flags = OTHER * other | ERROR * received.is_error_frame
            frame = received.arbitration_id | flags, bytes(received.data)
            if not self._is_own(received, frame):
                return frame
        return None

    def _is_own(self, received: can.Message, frame: Frame) -> bool:
        """Whether a received frame was sent by this bus."""
        if self._interface == "socketcan":  # it marks frames of other programs here, and returns none
            return False
        if self._interface != "udp_multicast":
            return not received.is_rx
        is_own = frame in self._sent  # the multicast returns every frame, unmarked
        if is_own:
            self._sent.remove(frame)
        return is_own


READ = 4096
"""Maximum number of bytes read at once."""
LONGEST_LINE = 1 << 16
"""Maximum length of a line [bytes]; longer input is discarded, because no adapter sends such a line."""
KINDS = {"t": (3, 0), "r": (3, OTHER), "d": (3, OTHER), "b": (3, OTHER)}
KINDS |= {letter: (8, OTHER) for letter in "TxRDB"}
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


def transport_of(bus: can.BusABC, interface: str) -> Transport:
    """Transport for an open bus of an interface of python-can."""
    if interface == "slcan" and hasattr(port := getattr(bus, "serialPortOrig", None), "fd"):
        return SlcanTransport(port)
    return PythonCanTransport(bus, interface)
