"""Dispatch of MuJoCo's callbacks, which a process shares between all models, to the arm of each model.

MuJoCo calls a Python callback for every model, including one that is still being compiled, where it fails. A
callback with a C signature receives the addresses of a model and an `MjData` instead, and can ignore other
models. The offsets of the arrays in that struct are learned from an `MjData` whose arrays Python knows; they
are the same for every `MjData` of one version of MuJoCo.
"""

import os
import sys
from ctypes import CFUNCTYPE, PyDLL, c_double, c_int, c_void_p, sizeof
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..errors import RobotError
from ..notebook import optional

KIND = CFUNCTYPE(None, c_void_p, c_void_p)
PURPOSE = "simulation in MuJoCo"
FARTHEST = 1 << 20
"""Bytes of the struct that are searched for an array: warnings and timers come first."""
MARK = 1.2345678e-99
"""A time that does not occur in any simulation."""


ARMS: dict[int, Any] = {}
"""Effects by the address of their model: an `Attached` each."""


def _calling(name: str) -> Any:
    def call(model: int, data: int) -> None:
        arm = ARMS.get(model)
        if arm is not None:
            getattr(arm, name)(data)

    return KIND(call)


CALLS = {name: _calling(name) for name in ("passive", "control")}


def register(model: Any, arm: Any) -> None:
    """Register an arm for a model that has none, unless other code uses MuJoCo's callbacks."""
    mujoco = optional("mujoco", PURPOSE, "mujoco")
    if model._address in ARMS:
        raise RobotError("the model already has effects attached; call detach() on them first")
    calls = {} if ARMS else CALLS
    for name in calls:
        if getattr(mujoco, f"get_mjcb_{name}")() is not None:
            raise RobotError(
                f"MuJoCo's callback mjcb_{name} is in use by another function, and a process can have only "
                f"one. Clear it with mujoco.set_mjcb_{name}(None)"
            )
    for name, call in calls.items():
        getattr(mujoco, f"set_mjcb_{name}")(call)
    ARMS[model._address] = arm


def release(model: Any) -> None:
    """Unregister the arm of a model, and clear the callbacks after the last one."""
    mujoco = optional("mujoco", PURPOSE, "mujoco")
    if ARMS.pop(model._address, None) is not None and not ARMS:
        for name in CALLS:
            getattr(mujoco, f"set_mjcb_{name}")(None)


@cache
def library() -> PyDLL:
    """MuJoCo's C library, whose functions take the addresses that a callback receives."""
    folder = os.path.dirname(optional("mujoco", PURPOSE, "mujoco").__file__)
    ending = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
    for name in sorted(os.listdir(folder)):
        if "mujoco" in name and not name.startswith("_") and ending in name:
            library = PyDLL(os.path.join(folder, name))
            library.mj_factorM.argtypes, library.mj_factorM.restype = (c_void_p, c_void_p), None
            library.mj_rne.argtypes, library.mj_rne.restype = (c_void_p, c_void_p, c_int, c_void_p), None
            return library
    raise RobotError(f"{folder} contains no MuJoCo library (*mujoco*{ending}); reinstall the package mujoco")


class Layout(NamedTuple):
    """Offsets in the struct of an `MjData` [byte], and sizes of its arrays."""

    places: dict[str, int]  # name -> offset of the pointer to the array
    sizes: dict[str, int]  # name -> number of elements
    time: int  # offset of the time

    @classmethod
    def of(cls, data: Any, names: tuple[str, ...]) -> "Layout":
        """Learn the layout from an `MjData` of the Python package."""
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
    """Offset of a word at most `FARTHEST` behind an address [byte]."""
    for offset in range(0, FARTHEST, sizeof(c_void_p)):
        if c_void_p.from_address(start + offset).value == word:
            return offset
    raise RobotError(
        f"this version of MuJoCo is not supported: {name} is not in the first {FARTHEST} bytes of its struct"
    )
