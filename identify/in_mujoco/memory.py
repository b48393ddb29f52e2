"""Arrays of an `MjData`, found by the address that C callbacks receive.

A C callback receives two addresses. The offsets of the arrays in the struct are learned from an `MjData`
whose arrays Python knows; they are the same for every `MjData` of one version of MuJoCo.
"""

from ctypes import c_double, c_void_p, sizeof
from typing import Any, NamedTuple

import numpy as np

from ..errors import RobotError

FARTHEST = 1 << 20
"""Bytes of the struct that are searched for an array: warnings and timers come first."""
MARK = 1.2345678e-99
"""A time that does not occur in any simulation."""


class Layout(NamedTuple):
    """Offsets in the struct of an `MjData` [byte], and sizes of its arrays."""

    places: dict[str, int]  # name -> offset of the pointer to the array
    sizes: dict[str, int]  # name -> number of elements
    time: int  # offset of the time

    @classmethod
    def of(cls, data: Any, names: tuple[str, ...]) -> "Layout":
        """Learn the layout from an `MjData` of the Python package.

        Raises:
            RobotError: If this version of MuJoCo has an unknown layout.
        """
        start = int(data._address)
        arrays = {name: getattr(data, name) for name in names}
        places = {name: find(start, array.ctypes.data, name) for name, array in arrays.items()}
        before = data.time
        data.time = MARK
        try:
            time = find(start, int.from_bytes(np.float64(MARK).tobytes(), "little"), "time")
        finally:
            data.time = before
        return cls(places, {name: array.size for name, array in arrays.items()}, time)

    def pointer(self, data: int, name: str) -> int:
        """Address of an array of the `MjData` at an address."""
        return c_void_p.from_address(data + self.places[name]).value or 0

    def array(self, data: int, name: str) -> np.ndarray:
        """An array of the `MjData` at an address, as a view of MuJoCo's own memory."""
        view = (c_double * self.sizes[name]).from_address(self.pointer(data, name))
        return np.ctypeslib.as_array(view)

    def clock(self, data: int) -> c_double:
        """Simulation time of the `MjData` at an address; `value` is always current [s]."""
        return c_double.from_address(data + self.time)


def find(start: int, word: int, name: str) -> int:
    """Offset of a word behind an address [byte].

    Raises:
        RobotError: If it is not within `FARTHEST`.
    """
    for offset in range(0, FARTHEST, sizeof(c_void_p)):
        if c_void_p.from_address(start + offset).value == word:
            return offset
    raise RobotError(
        f"this version of MuJoCo is not supported: {name} is not in the first {FARTHEST} bytes of its struct"
    )
