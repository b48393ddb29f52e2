"""The connection to the controller's RTDE server: questions and answers, then the newest data package."""

import select
import socket
import time
from collections import deque

from ..errors import LinkLost
from ..host_clock import host_time
from .rtde_packets import DATA, TEXT, Unpacked, package, text_of

READ = 1 << 16
"""Bytes that are taken at once: 200 packages."""


class RtdeLink:
    """A connection.

    Args:
        address: Of the controller.
        port: Of its server.
        patience: How long it may take to connect and to answer [s].

    Attributes:
        texts: Messages of the controller that were not looked at yet.

    Raises:
        LinkLost: No connection.
    """

    def __init__(self, address: str, port: int, patience: float) -> None:
        self._where, self._patience = f"{address}:{port}", patience
        try:
            self._socket = socket.create_connection((address, port), patience)
        except OSError as error:
            raise LinkLost(
                f"driver ur_rtde: no connection to {self._where}: {error.strerror or error}. Try ping, and "
                "on the pendant Settings, Security, Services: RTDE must be enabled"
            ) from error
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.setblocking(False)
        self._waited_for = [self._socket.fileno()]
        self._unpacked = Unpacked()
        self._waiting: deque[tuple[bytes, bytes]] = deque()
        self.texts: deque[str] = deque(maxlen=100)

    def ask(self, kind: bytes, body: bytes = b"") -> bytes:
        """The answer to a question; data that come before it are thrown away.

        Raises:
            LinkLost: None comes.
        """
        self.send(package(kind, body))
        end = time.monotonic() + self._patience
        while time.monotonic() < end:
            self._receive(end - time.monotonic())
            while self._waiting:
                which, answer = self._waiting.popleft()
                if which == kind:
                    return answer
        raise LinkLost(
            f"driver ur_rtde: {self._where} does not answer question {kind.decode()} in {self._patience:g} "
            "s. Is this a controller's RTDE server (port 30004)?"
        )

    def newest(self, patience: float) -> tuple[bytes, int] | None:
        """Body of the newest data package and when it came [ns since 1970]; None if none comes in time [s].

        Raises:
            LinkLost: The connection has ended.
        """
        end = time.monotonic() + patience
        while True:
            self._receive(max(end - time.monotonic(), 0.0))
            now = host_time()
            bodies = [body for kind, body in self._waiting if kind == DATA]
            self._waiting.clear()
            if bodies:
                return bodies[-1], now
            if time.monotonic() >= end:
                return None

    def send(self, data: bytes) -> bool:
        """Whether the network took it all.

        Raises:
            LinkLost: The connection has ended.
        """
        try:
            return self._socket.send(data) == len(data)
        except BlockingIOError:
            return False
        except OSError as error:
            raise LinkLost(f"driver ur_rtde: {self._where}: {error.strerror or error}") from error

    def _receive(self, patience: float) -> None:
        """Take in what is there, or what comes first."""
        try:
            if not select.select(self._waited_for, [], [], patience)[0]:
                return
            data = self._socket.recv(READ)
            if not data:
                raise LinkLost(
                    f"driver ur_rtde: {self._where} has ended the connection: the controller was shut down "
                    "or its server restarted"
                )
            for kind, body in self._unpacked.add(data):
                if kind == TEXT:
                    self.texts.append(text_of(body))
                else:
                    self._waiting.append((kind, body))
        except BlockingIOError:
            return
        except OSError as error:
            raise LinkLost(f"driver ur_rtde: {self._where}: {error.strerror or error}") from error
        except ValueError as error:
            raise LinkLost(f"driver ur_rtde: {self._where} sends what is not RTDE: {error}") from error

    def close(self) -> None:
        """Let go."""
        self._socket.close()
