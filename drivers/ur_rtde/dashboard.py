"""Dashboard server of a Universal Robots controller: questions and answers as lines of text."""

import socket
from contextlib import suppress

from ..host_clock import HOST, Clock

LONGEST = 4096
"""Maximum number of bytes read at once, and of an answer."""
ANSWERED = 1.0
"""Maximum time to wait for the answer to a request [s]; some 10 ms are usual."""


class Dashboard:
    """A connection to the dashboard server, if there is one; PolyScope X has none.

    Connecting and `ask` wait at most `patience` [s] each; all other methods return at once.
    """

    def __init__(self, address: str, port: int, patience: float, clock: Clock = HOST) -> None:
        self._clock = clock
        self._socket: socket.socket | None = None
        self._patience, self._text = patience, b""
        self._asked, self._due = "", 0.0
        with suppress(OSError):
            self._socket = socket.create_connection((address, port), patience)
            self._socket.setblocking(False)
            self._line()  # the greeting

    @property
    def there(self) -> bool:
        return self._socket is not None

    def ask(self, question: str) -> str:
        """Ask a question and return the answer; empty without an answer."""
        return self._line() if self._sent(question) else ""

    def request(self, question: str) -> str:
        """Send a request without waiting; returns why it was not sent, or an empty text."""
        if not self._sent(question):
            return f"the controller's dashboard does not take '{question}'"
        self._asked, self._due, self._text = question, self._clock.monotonic() + ANSWERED, b""
        return ""

    def answers(self) -> list[str]:
        """The controller's answer to a request since the last call, or that none came in time."""
        if not self._asked:
            return []
        self._receive()
        *lines, self._text = self._text.split(b"\n")
        if not lines and self._clock.monotonic() < self._due:
            return []
        question, self._asked = self._asked, ""
        answer = lines[0].decode("utf-8", "replace").strip() if lines else ""
        return [f"the controller's dashboard to '{question}': {answer or f'no answer in {ANSWERED:g} s'}"]

    def _sent(self, question: str) -> bool:
        if self._socket is None:
            return False
        data = f"{question}\n".encode()
        try:
            return self._socket.send(data) == len(data)
        except OSError:
            self.close()
            return False

    def _line(self) -> str:
        """Wait for the next line; empty if none comes in time."""
        end = self._clock.monotonic() + self._patience
        while b"\n" not in self._text and self._socket is not None and self._clock.monotonic() < end:
            self._clock.readable([self._socket.fileno()], max(end - self._clock.monotonic(), 0.0))
            self._receive()
        line, newline, remainder = self._text.partition(b"\n")
        self._text = remainder if newline else b""
        return line.decode("utf-8", "replace").strip() if newline else ""

    def _receive(self) -> None:
        """Receive available bytes. Close the connection if the server ends it, or if a line is too long."""
        if self._socket is None:
            return
        try:
            data = self._socket.recv(LONGEST)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        self._text += data
        if not data or (len(self._text) > LONGEST and b"\n" not in self._text):
            self.close()

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None
