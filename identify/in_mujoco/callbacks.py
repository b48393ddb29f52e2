"""Dispatch of MuJoCo's callbacks, which a process shares between all models, to the arm of each model.

MuJoCo calls a Python callback for every model, including one that is still being compiled, where it fails. A
callback with a C signature receives addresses instead, and can ignore other models.
"""

import os
import sys
from ctypes import CFUNCTYPE, PyDLL, c_int, c_void_p
from functools import cache
from typing import Any, Protocol

from ..errors import RobotError
from ..notebook import optional

KIND = CFUNCTYPE(None, c_void_p, c_void_p)
PURPOSE = "simulation in MuJoCo"


class Forced(Protocol):
    """Effects on one model; the address tells which `MjData` is stepped."""

    def passive(self, data: int) -> None:
        """Called after passive forces have been summed."""

    def control(self, data: int) -> None:
        """Called before actuators, in steps but not in inverse dynamics."""


ARMS: dict[int, Forced] = {}
"""Effects by the address of their model."""


def _calling(name: str) -> Any:
    def call(model: int, data: int) -> None:
        arm = ARMS.get(model)
        if arm is not None:
            getattr(arm, name)(data)

    return KIND(call)


CALLS = {name: _calling(name) for name in ("passive", "control")}


def register(model: Any, arm: Forced) -> None:
    """Register an arm for a model.

    Raises:
        RobotError: If other code uses MuJoCo's callbacks, or the model has an arm already.
    """
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
    """MuJoCo's C library, whose functions take the addresses that a callback receives.

    Raises:
        RobotError: If the folder of the Python package contains no library.
    """
    folder = os.path.dirname(optional("mujoco", PURPOSE, "mujoco").__file__)
    ending = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
    for name in sorted(os.listdir(folder)):
        if "mujoco" in name and not name.startswith("_") and ending in name:
            return _typed(PyDLL(os.path.join(folder, name)))
    raise RobotError(f"{folder} contains no MuJoCo library (*mujoco*{ending}); reinstall the package mujoco")


def _typed(library: PyDLL) -> PyDLL:
    library.mj_factorM.argtypes, library.mj_factorM.restype = (c_void_p, c_void_p), None
    library.mj_rne.argtypes, library.mj_rne.restype = (c_void_p, c_void_p, c_int, c_void_p), None
    return library
