"""Transport: hands frames to a CAN adapter and takes frames from it.

python-can makes an object of every frame, checks, filters and logs it. For the frames of six joints this
takes longer than all other work of a cycle. Where python-can has a socket or a serial port that can be used
directly, a file of this folder does so. All other interfaces go through python-can, by `PythonCanTransport`.
"""

from collections.abc import Callable, Sequence
from typing import Protocol

import can

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


class Transport(Protocol):
    """Frames to an adapter and from it; what the adapter or the system raises is raised."""

    def send(self, frames: Sequence[Frame], timeout: float) -> None:
        """Hand frames over, each within a time-out [s]; after one that fails the others are tried."""

    def receive(self, timeout: float) -> Frame | None:
        """The next frame, waited for at most so long [s]; None if there is none.

        Raises:
            ValueError: What came is not a frame. Also other errors, by interface.
        """

    def close(self) -> None:
        """Let go of what is its own; the bus is closed by python-can."""


class PythonCanTransport:
    """Any interface, by the methods that python-can gives all of them.

    Args:
        bus: Open.
    """

    def __init__(self, bus: can.BusABC) -> None:
        self._bus = bus

    def send(self, frames: Sequence[Frame], timeout: float) -> None:
        """As in `Transport`."""
        send_each(frames, lambda identifier, data: self._bus.send(message(identifier, data), timeout))

    def receive(self, timeout: float) -> Frame | None:
        """As in `Transport`."""
        received = self._bus.recv(timeout)
        return None if received is None else (flagged(received), bytes(received.data))

    def close(self) -> None:
        """As in `Transport`."""


def send_each(frames: Sequence[Frame], send: Callable[[int, bytes], None]) -> None:
    """Send every frame, also after one that fails; the first failure is raised at the end."""
    failure: Exception | None = None
    for identifier, data in frames:
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
