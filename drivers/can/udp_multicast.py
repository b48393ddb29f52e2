"""CAN bus of python-can without hardware: each frame is a multicast datagram with a MessagePack map."""

import os
import socket
from collections import Counter
from typing import Any

import can
import msgpack  # type: ignore[import-untyped]
from can.interfaces.udp_multicast.utils import pack_message

from .transports import STANDARD, Frame, SocketTransport, flagged, message

PORT = 43113
"""Default port of the bus, as in python-can."""
DATA = b"\xa4data\xc4"
"""Bytes before the data in a datagram: the key, and the MessagePack type for bytes; their number follows."""
KINDS = ("is_extended_id", "is_remote_frame", "is_error_frame", "is_fd")
"""Names of the flags of frames that are not data frames with an 11-bit identifier."""
REMEMBERED = 1000
"""Maximum number of remembered datagrams that have not come back, and of known beginnings of received ones.
If there are more, some were lost, or a sender adds time stamps."""


class UdpMulticastTransport(SocketTransport):
    """A multicast bus over the socket of python-can; datagrams that come back to their sender are skipped."""

    def __init__(self, descriptor: int, group: str, port: int | None) -> None:
        super().__init__(socket.socket(fileno=os.dup(descriptor)))
        self._address = group, port or PORT
        self._sent = Counter[bytes]()  # the same datagram may be on its way twice
        self._received: dict[bytes, tuple[int, bytes]] = {}
        self._around: dict[tuple[int, int], tuple[bytes, bytes]] = {}

    def _encode(self, identifier: int, data: bytes) -> bytes:
        kind = identifier, len(data)
        around = self._around.get(kind)
        if around is None:
            around = self._around[kind] = self._parts(identifier, len(data))
        return b"".join((around[0], data, around[1]))

    def _parts(self, identifier: int, length: int) -> tuple[bytes, bytes]:
        """Bytes before and after the data, the same for all frames of this identifier and length."""
        datagram = pack_message(message(identifier, bytes(length)))
        begin = datagram.index(DATA) + len(DATA) + 1
        return datagram[:begin], datagram[begin + length :]

    def _decode(self, datagram: bytes) -> Frame | None:
        if datagram in self._sent:
            self._sent[datagram] -= 1
            if not self._sent[datagram]:
                del self._sent[datagram]
            return None
        begin = datagram.find(DATA) + len(DATA) + 1
        known = self._received.get(datagram[:begin])
        if known is not None:
            identifier, ending = known
            end = begin + datagram[begin - 1]
            if datagram[end:] == ending:
                return identifier, datagram[begin:end]
        return self._learn(datagram, begin)

    def _learn(self, datagram: bytes, begin: int) -> Frame:
        """Decode a datagram in full, and remember the bytes around its data to recognize the next one."""
        identifier, data = self._unpack(datagram)
        end = begin + len(data)
        if identifier <= STANDARD and datagram[begin:end] == data:
            if len(self._received) > REMEMBERED:
                self._received.clear()
            self._received[datagram[:begin]] = identifier, datagram[end:]
        return identifier, data

    def _unpack(self, datagram: bytes) -> Frame:
        fields: dict[str, Any] = msgpack.unpackb(datagram)
        identifier, data = fields["arbitration_id"], fields["data"]
        if any(map(fields.__getitem__, KINDS)):
            return flagged(can.Message(**fields, check=True)), data
        if not 0 <= identifier <= STANDARD or type(data) is not bytes or fields["dlc"] != len(data):
            raise ValueError("a datagram that is not a frame")
        return identifier, data

    def _hand_over(self, datagram: bytes) -> None:
        if len(self._sent) > REMEMBERED:
            self._sent.clear()
        self._sent[datagram] += 1
        self._socket.sendto(datagram, socket.MSG_DONTWAIT, self._address)

    def close(self) -> None:
        self._socket.close()
