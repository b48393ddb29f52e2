"""The controller's text servers: the dashboard, which is asked, and the one that programs are sent to."""

import socket
from collections.abc import Iterator
from contextlib import contextmanager

from ..errors import LinkLost

LONGEST = 4096
"""Bytes of an answer."""


class Dashboard:
    """A connection to the dashboard server, where there is one; PolyScope X has none.

    Args:
        address: Of the controller.
        port: Of the server.
        patience: How long each answer may take [s].
    """

    def __init__(self, address: str, port: int, patience: float) -> None:
        self._socket: socket.socket | None = None
        try:
            self._socket = socket.create_connection((address, port), patience)
            self._line()  # it greets
        except OSError:
            self.close()

    @property
    def there(self) -> bool:
        """Whether it answers."""
        return self._socket is not None

    def ask(self, question: str) -> str:
        """Its answer; empty where there is none."""
        if self._socket is None:
            return ""
        try:
            self._socket.sendall(f"{question}\n".encode())
            return self._line()
        except OSError:
            self.close()
            return ""

    def _line(self) -> str:
        assert self._socket is not None
        line = b""
        while not line.endswith(b"\n") and len(line) < LONGEST:
            more = self._socket.recv(LONGEST)
            if not more:
                raise ConnectionResetError
            line += more
        return line.decode("utf-8", "replace").strip()

    def close(self) -> None:
        """Let go."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


@contextmanager
def program_sent(address: str, port: int, text: str, patience: float) -> Iterator[None]:
    """Hand the controller a program, which it begins at once where it takes programs from here.

    The connection is kept for the block: what is closed at once may be lost.

    Raises:
        LinkLost: No connection.
    """
    try:
        link = socket.create_connection((address, port), patience)
        link.sendall(text.encode())
    except OSError as error:
        raise LinkLost(
            f"driver ur_rtde: no program could be sent to {address}:{port}: {error.strerror or error}. Try, "
            "on the pendant, Settings, Security, Services: Secondary Client must be enabled"
        ) from error
    with link:
        yield
