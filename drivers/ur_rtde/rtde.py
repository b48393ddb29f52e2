"""Protocol RTDE, version 2, and a connection to its server on the controller.

A package is a size, a kind and a body, in big-endian numbers. A recipe is a list of names that client and
controller agree on; a data package contains the number of the recipe and the values.
"""

import socket
import struct
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import LinkLost
from ..host_clock import HOST, Clock

PROTOCOL = 2
"""Version of the protocol; version 1 has neither frequency nor recipe numbers."""
VERSION, CONTROLLER, TEXT, DATA = b"V", b"v", b"M", b"U"
OUTPUTS, INPUTS, START, PAUSE = b"O", b"I", b"S", b"P"
"""Kinds of packages."""

_HEAD = struct.Struct(">Hc")
_TYPES: Mapping[str, Any] = {
    "BOOL": "?",
    "UINT8": "u1",
    "UINT32": ">u4",
    "UINT64": ">u8",
    "INT32": ">i4",
    "DOUBLE": ">f8",
    "VECTOR3D": (">f8", 3),
    "VECTOR6D": (">f8", 6),
    "VECTOR6INT32": (">i4", 6),
    "VECTOR6UINT32": (">u4", 6),
}
_SCALARS: Mapping[str, str] = {
    "BOOL": "?", "UINT8": "B", "UINT32": "I", "UINT64": "Q", "INT32": "i", "DOUBLE": "d",
}  # fmt: skip
NOT_FOUND, IN_USE = "NOT_FOUND", "IN_USE"
"""Answers in place of a type: the controller has no such name, or another client writes it."""


def package(kind: bytes, body: bytes = b"") -> bytes:
    """Encode a package."""
    return _HEAD.pack(_HEAD.size + len(body), kind) + body


class Unpacked:
    """Splits a stream of bytes into packages."""

    def __init__(self) -> None:
        self._waiting = b""

    def add(self, data: bytes) -> Iterator[tuple[bytes, bytes]]:
        """Add bytes, and yield kind and body of each complete package. Raises ValueError if invalid."""
        self._waiting += data
        while len(self._waiting) >= _HEAD.size:
            size, kind = _HEAD.unpack_from(self._waiting)
            if size < _HEAD.size:
                raise ValueError(f"a package of {size} bytes")
            if len(self._waiting) < size:
                return
            body, self._waiting = self._waiting[_HEAD.size : size], self._waiting[size:]
            yield kind, body


class Recipe:
    """Recipe for a list of names: its number, 0 if the controller refused it, and the types of the values.

    Raises ValueError if the answer does not belong to these names.
    """

    def __init__(self, names: Sequence[str], answer: bytes) -> None:
        self.number, self.types = (answer[0] if answer else 0), answer[1:].decode("ascii").split(",")
        if len(self.types) != len(names):
            raise ValueError(f"{len(self.types)} types for {len(names)} names")
        self._refused = {
            name: kind for name, kind in zip(names, self.types, strict=True) if kind not in _TYPES
        }
        if not self._refused:
            fields = [(name, _TYPES[kind]) for name, kind in zip(names, self.types, strict=True)]
            self._dtype = np.dtype([("recipe", "u1"), *fields])
            self._names, scalars = names, [_SCALARS.get(kind, "") for kind in self.types]
            # Filling a NumPy record takes five times as long.
            self._scalars = struct.Struct(">B" + "".join(scalars)) if all(scalars) else None

    def refused(self, why: str) -> list[str]:
        """Names that the controller refused for a reason: `NOT_FOUND` or `IN_USE`."""
        return [name for name, kind in self._refused.items() if kind == why]

    @property
    def accepted(self) -> bool:
        return not self._refused and self.number > 0

    def read(self, body: bytes) -> np.void:
        """Decode a data package, one field per name. Raises ValueError for another recipe or length."""
        if len(body) != self._dtype.itemsize or body[0] != self.number:
            raise ValueError(f"{len(body)} bytes; expected {self._dtype.itemsize} of recipe {self.number}")
        record: np.void = np.frombuffer(body, self._dtype)[0]
        return record

    def written(self, values: Mapping[str, Any]) -> bytes:
        """Encode the body of a data package; names without a value are zero."""
        if self._scalars is not None:
            return self._scalars.pack(self.number, *(values.get(name, 0) for name in self._names))
        record = np.zeros(1, self._dtype)
        record["recipe"] = self.number
        for name, value in values.items():
            record[name] = value
        return record.tobytes()


def text_of(body: bytes) -> str:
    """Text in a text package; empty if the package is broken."""
    length = body[0] if body else 0
    return body[1 : 1 + length].decode("utf-8", "replace").strip()


READ = 1 << 16
"""Maximum number of bytes read at once: 200 packages."""


class RtdeLink:
    """A connection to the RTDE server, which answers within `patience` [s]. Raises LinkLost without it."""

    def __init__(self, address: str, port: int, patience: float, clock: Clock = HOST) -> None:
        self._clock = clock
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
        self.texts: deque[str] = deque(maxlen=100)  # messages of the controller that were not read yet

    def ask(self, kind: bytes, body: bytes = b"") -> bytes:
        """Ask a question and return the answer, discarding data before it. Raises LinkLost if none comes."""
        self.send(package(kind, body))
        end = self._clock.monotonic() + self._patience
        while self._clock.monotonic() < end:
            self._receive(end - self._clock.monotonic())
            while self._waiting:
                answer_kind, answer = self._waiting.popleft()
                if answer_kind == kind:
                    return answer
        raise LinkLost(
            f"driver ur_rtde: {self._where} does not answer question {kind.decode()} in {self._patience:g} "
            "s. Is this a controller's RTDE server (port 30004)?"
        )

    def newest(self, patience: float) -> tuple[bytes, int] | None:
        """Body of the newest data package and its time of arrival [ns since 1970].

        None if no package comes within `patience` [s]. Raises LinkLost if the connection has ended.
        """
        end = self._clock.monotonic() + patience
        while True:
            self._receive(max(end - self._clock.monotonic(), 0.0))
            now = self._clock.host_time()
            bodies = [body for kind, body in self._waiting if kind == DATA]
            self._waiting.clear()
            if bodies:
                return bodies[-1], now
            if self._clock.monotonic() >= end:
                return None

    def send(self, data: bytes) -> bool:
        """Send bytes; returns whether all were sent. Raises LinkLost if the connection has ended."""
        try:
            return self._socket.send(data) == len(data)
        except BlockingIOError:
            return False
        except OSError as error:
            raise LinkLost(f"driver ur_rtde: {self._where}: {error.strerror or error}") from error

    def _receive(self, patience: float) -> None:
        try:
            if not self._clock.readable(self._waited_for, patience):
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
            raise LinkLost(f"driver ur_rtde: {self._where} does not speak RTDE: {error}") from error

    def close(self) -> None:
        self._socket.close()
