"""SocketCAN, the CAN adapters of Linux: frames as the kernel keeps them, over python-can's raw socket."""

import socket
import struct

from .socket_transport import SocketTransport
from .transport import FD, IDENTIFIER, Frame

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
