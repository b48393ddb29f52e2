"""Packages of RTDE, version 2 of the protocol: a size, a kind and a body, in big-endian numbers.

A recipe is a list of names that client and controller agree on; a data package is its number and the values.
"""

import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

PROTOCOL = 2
"""Version of the protocol; the first has no frequency and no numbers of recipes."""
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
"""Instead of a type: the controller has no such name, or another client writes it."""


def package(kind: bytes, body: bytes = b"") -> bytes:
    """The bytes of a package."""
    return _HEAD.pack(_HEAD.size + len(body), kind) + body


class Unpacked:
    """Packages out of bytes that come in any pieces."""

    def __init__(self) -> None:
        self._waiting = b""

    def add(self, data: bytes) -> Iterator[tuple[bytes, bytes]]:
        """Kind and body of each package that is whole by now.

        Raises:
            ValueError: What comes cannot be packages.
        """
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
    """What the controller made of a list of names.

    Args:
        names: As they were asked for.
        answer: Body of the controller's answer.

    Attributes:
        number: Of the recipe; 0 where it was refused.
        types: Of the values.

    Raises:
        ValueError: It is no answer to these names.
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
            # A record of numpy's takes five times as long to fill.
            self._scalars = struct.Struct(">B" + "".join(scalars)) if all(scalars) else None

    def refused(self, why: str) -> list[str]:
        """Names that the controller refused for a reason: `NOT_FOUND` or `IN_USE`."""
        return [name for name, kind in self._refused.items() if kind == why]

    @property
    def accepted(self) -> bool:
        """Whether all names were taken."""
        return not self._refused and self.number > 0

    def read(self, body: bytes) -> np.void:
        """The record of a data package, a field a name.

        Raises:
            ValueError: It is of another recipe or length.
        """
        if len(body) != self._dtype.itemsize or body[0] != self.number:
            raise ValueError(f"{len(body)} bytes; expected {self._dtype.itemsize} of recipe {self.number}")
        record: np.void = np.frombuffer(body, self._dtype)[0]
        return record

    def written(self, values: Mapping[str, Any]) -> bytes:
        """Body of a data package; zeros for names without a value."""
        if self._scalars is not None:
            return self._scalars.pack(self.number, *(values.get(name, 0) for name in self._names))
        record = np.zeros(1, self._dtype)
        record["recipe"] = self.number
        for name, value in values.items():
            record[name] = value
        return record.tobytes()


def text_of(body: bytes) -> str:
    """The sentence in a text package; empty for one that is broken."""
    length = body[0] if body else 0
    return body[1 : 1 + length].decode("utf-8", "replace").strip()
