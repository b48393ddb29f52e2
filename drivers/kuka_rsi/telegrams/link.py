"""The socket of the conversation with a KUKA controller: its address only, whatever else comes in."""

import errno
import select
import socket
import struct
import sys
import time
from typing import NamedTuple

from ...errors import BadSettings, NotReady
from ...host_clock import host_time

LONGEST = 65535
MOST = 256
"""Datagrams taken at once: a full buffer of telegrams, so that a flood cannot keep the loop here."""
_STAMPED = 35  # SO_TIMESTAMPNS of Linux, which Python does not name
_TIME = struct.Struct("@ll")
_OLDEST = 10_000_000_000
"""A receive time longer ago than this is not accepted: the wall clock was set since [ns]."""


class Datagram(NamedTuple):
    """What came in.

    Attributes:
        data: Bytes.
        port: The sender's, which a controller chooses anew for every session.
        arrival: When the network card's driver had it [ns since 1970], on the clock of `host_time`.
    """

    data: bytes
    port: int
    arrival: int


class Link:
    """A UDP socket bound to one address of this computer.

    Args:
        address: Of this computer.
        port: Where the controller sends to.
        controller: The only address that is listened to and answered.

    Raises:
        BadSettings: An address that this computer does not have, or that is none.
        NotReady: A port that is in use.
    """

    strangers: int
    """Datagrams from other addresses, which were ignored."""
    stranger: str
    """The last of those addresses."""
    strange: Datagram
    """What came from there last."""

    def __init__(self, address: str, port: int, controller: str) -> None:
        self._controller = controller
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.strangers = 0
        self.stranger = ""
        try:
            self._bind(address, port)
        except BaseException:
            self._socket.close()
            raise
        self._socket.setblocking(False)
        self._waited_for = [self._socket.fileno()]
        if sys.platform == "linux":  # elsewhere the times of arrival are those of reading
            self._socket.setsockopt(socket.SOL_SOCKET, _STAMPED, 1)

    def _bind(self, address: str, port: int) -> None:
        try:
            self._socket.bind((address, port))
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise NotReady(
                    f"{address}:{port} is taken by another program. Is a second driver running?"
                ) from error
            raise BadSettings(
                f"cannot listen on {address}:{port}: {error.strerror or error}. IP_NUMBER must be the "
                "address of this computer in the controller's network; set bind if the two differ on purpose"
            ) from error

    def wait(self, seconds: float) -> list[Datagram]:
        """All that has come from the controller; waits for the first of it, but not longer."""
        deadline = time.monotonic() + seconds
        while True:
            left = max(deadline - time.monotonic(), 0.0)
            ready, _, _ = select.select(self._waited_for, [], [], left)
            found = self._waiting() if ready else []
            if found or not left:
                return found

    def _waiting(self) -> list[Datagram]:
        found = []
        for _ in range(MOST):
            try:
                data, extra, (address, port) = self._read()
            except BlockingIOError:
                break
            except OSError:
                continue  # an earlier answer was refused by the network, which is no telegram
            if address == self._controller:
                found.append(Datagram(data, port, _arrival(extra)))
            else:
                self.strangers += 1
                self.stranger, self.strange = address, Datagram(data, port, 0)
        return found

    def _read(self) -> tuple[bytes, list[tuple[int, int, bytes]], tuple[str, int]]:
        if sys.platform == "linux":
            data, extra, _, sender = self._socket.recvmsg(LONGEST, 64)
            return data, extra, sender
        data, sender = self._socket.recvfrom(LONGEST)
        return data, [], sender

    def answer(self, data: bytes, port: int) -> bool:
        """Send to the controller; whether the network took it."""
        try:
            self._socket.sendto(data, (self._controller, port))
        except OSError:
            return False
        return True

    def close(self) -> None:
        """Let go of the port."""
        self._socket.close()


def _arrival(extra: list[tuple[int, int, bytes]]) -> int:
    now = host_time()
    for _, kind, content in extra:
        if kind == _STAMPED and len(content) >= _TIME.size:
            seconds, rest = _TIME.unpack_from(content)
            age = time.time_ns() - seconds * 1_000_000_000 - rest
            return now - age if 0 <= age < _OLDEST else now
    return now
