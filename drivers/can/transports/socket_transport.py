"""Sockets that carry one CAN frame a datagram: what SocketCAN and python-can's multicast have in common."""

import select
import socket
from abc import ABC, abstractmethod
from collections.abc import Sequence

from .transport import Frame, send_each

LONGEST = 400
"""Bytes of a datagram that are read: more than any has. Python has objects of up to 512 bytes quickly."""


class SocketTransport(ABC):
    """Frames over a socket; the socket stays python-can's, and is not closed here.

    Args:
        link: Open. Whether it blocks does not matter.
    """

    def __init__(self, link: socket.socket) -> None:
        self._socket, self._waited_for = link, [link.fileno()]

    @abstractmethod
    def _encode(self, identifier: int, data: bytes) -> bytes:
        """The datagram of a frame of data with an 11-bit identifier."""

    @abstractmethod
    def _decode(self, datagram: bytes) -> Frame | None:
        """The frame in a datagram; None for one to be passed over.

        Raises:
            ValueError: It has none. Also KeyError and TypeError.
        """

    @abstractmethod
    def _hand_over(self, datagram: bytes) -> None:
        """Give a datagram to the socket without waiting.

        Raises:
            BlockingIOError: The socket does not take it now.
        """

    def send(self, frames: Sequence[Frame], timeout: float) -> None:
        """As in `Transport`."""

        def send(identifier: int, data: bytes) -> None:
            datagram = self._encode(identifier, data)
            try:
                self._hand_over(datagram)
            except BlockingIOError:
                select.select([], self._waited_for, [], timeout)
                self._hand_over(datagram)

        send_each(frames, send)

    def receive(self, timeout: float) -> Frame | None:
        """As in `Transport`."""
        if timeout > 0.0 and not select.select(self._waited_for, [], [], timeout)[0]:
            return None
        frame = None
        while frame is None:
            try:
                datagram = self._socket.recv(LONGEST, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return None
            frame = self._decode(datagram)
        return frame

    def close(self) -> None:  # noqa: B027 - a socket of python-can's is closed by python-can
        """As in `Transport`."""
