"""Arrays of MuJoCo's data, by the address that callbacks of C are given.

A callback in C's form hands out two addresses. Where in the struct its arrays are is learned from one whose
arrays Python knows, and is the same in all of one version of MuJoCo.
"""

from ctypes import c_double, c_void_p, sizeof
from typing import Any, NamedTuple

import numpy as np

from ..errors import RobotError

FARTHEST = 1 << 20
"""Bytes of the struct in which an array is looked for: it has warnings and timers before them."""
MARK = 1.2345678e-99
"""A time that no simulation has."""


class Layout(NamedTuple):
    """Where in the struct pointers to arrays are, and the time [byte]; and how long the arrays are.

    Attributes:
        places: Name -> place.
        sizes: Name -> count of numbers.
        time: Place of the time.
    """

    places: dict[str, int]
    sizes: dict[str, int]
    time: int

    @classmethod
    def of(cls, data: Any, names: tuple[str, ...]) -> "Layout":
        """Learn it from one of Python's.

        Raises:
            RobotError: This version of MuJoCo has it elsewhere.
        """
        start = int(data._address)
        arrays = {name: getattr(data, name) for name in names}
        places = {name: find(start, array.ctypes.data, name) for name, array in arrays.items()}
        before = data.time
        data.time = MARK
        try:
            time = find(start, number_bits(MARK), "time")
        finally:
            data.time = before
        return cls(places, {name: array.size for name, array in arrays.items()}, time)

    def pointer(self, data: int, name: str) -> int:
        """Address of an array of the data at an address."""
        return c_void_p.from_address(data + self.places[name]).value or 0

    def array(self, data: int, name: str) -> np.ndarray:
        """An array of the data at an address: the very memory that MuJoCo reads and writes."""
        there = (c_double * self.sizes[name]).from_address(self.pointer(data, name))
        return np.ctypeslib.as_array(there)

    def clock(self, data: int) -> c_double:
        """Its time, whose `value` goes on [s]."""
        return c_double.from_address(data + self.time)


def step_address(model: Any) -> int:
    """Where the time step of a model is, one of Python's."""
    before = model.opt.timestep
    model.opt.timestep = MARK
    try:
        return int(model._address) + find(int(model._address), number_bits(MARK), "timestep")
    finally:
        model.opt.timestep = before


def number_bits(number: float) -> int:
    """A number as its word in memory."""
    return int.from_bytes(np.float64(number).tobytes(), "little")


def find(start: int, word: int, name: str) -> int:
    """Where behind an address a word is [byte].

    Raises:
        RobotError: Nowhere.
    """
    for place in range(0, FARTHEST, sizeof(c_void_p)):
        if c_void_p.from_address(start + place).value == word:
            return place
    raise RobotError(f"MuJoCo's data has no {name} where it is looked for; this version of it is not known")
