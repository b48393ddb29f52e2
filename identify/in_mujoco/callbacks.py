"""MuJoCo's callbacks, which are one for all models of a process: which arm each call is for.

A function of Python's given to MuJoCo is called for models that Python does not know too, as while another is
compiled, and fails there. A function of C's is given addresses, and those of other models are left alone.
"""

import os
import sys
from collections.abc import Mapping
from ctypes import CFUNCTYPE, PyDLL, c_int, c_void_p
from functools import cache
from typing import Any, Protocol

from ..errors import RobotError
from ..notebook import optional

KIND = CFUNCTYPE(None, c_void_p, c_void_p)
PURPOSE = "what exidyn found, in MuJoCo,"


class Forced(Protocol):
    """What acts on one model, whichever data it is stepped with, by address."""

    def passive(self, data: int) -> None:
        """When passive forces have been added up."""

    def control(self, data: int) -> None:
        """Before actuators, in steps, and not in inverse dynamics."""


ARMS: dict[int, Forced] = {}
"""By the address of their model."""


def _calling(name: str) -> Any:
    def call(model: int, data: int) -> None:
        arm = ARMS.get(model)
        if arm is not None:
            getattr(arm, name)(data)

    return KIND(call)


CALLS = {name: _calling(name) for name in ("passive", "control")}


def register(model: Any, arm: Forced, calls: Mapping[str, Any] | None = None) -> None:
    """Have an arm called for a model, by functions that may be compiled and call `CALLS` for all else.

    Raises:
        RobotError: Somebody else has MuJoCo's callbacks, or the model has an arm already.
    """
    mujoco = optional("mujoco", PURPOSE, "mujoco")
    if model._address in ARMS:
        raise RobotError("the model has such effects attached already; detach() those first")
    for name in () if ARMS else CALLS:
        if getattr(mujoco, f"get_mjcb_{name}")() is not None:
            raise RobotError(
                f"mjcb_{name} of MuJoCo is taken by another function of this process; there can be one. Set "
                f"it to None: mujoco.set_mjcb_{name}(None)"
            )
    # What was compiled for other arms stays: it calls Python for arms that it does not know.
    for name, call in (calls or ({} if ARMS else CALLS)).items():
        getattr(mujoco, f"set_mjcb_{name}")(call)
    ARMS[model._address] = arm


def release(model: Any) -> None:
    """Have no arm called for a model, and nothing at all after the last."""
    mujoco = optional("mujoco", PURPOSE, "mujoco")
    if ARMS.pop(model._address, None) is not None and not ARMS:
        for name in CALLS:
            getattr(mujoco, f"set_mjcb_{name}")(None)


@cache
def library() -> PyDLL:
    """MuJoCo itself, whose functions take the addresses that a callback is given.

    Raises:
        RobotError: It is not beside its Python package.
    """
    folder = os.path.dirname(optional("mujoco", PURPOSE, "mujoco").__file__)
    ending = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
    for name in sorted(os.listdir(folder)):
        if "mujoco" in name and not name.startswith("_") and ending in name:
            return _typed(PyDLL(os.path.join(folder, name)))
    raise RobotError(f"{folder} has no library of MuJoCo's (*mujoco*{ending})")


def _typed(library: PyDLL) -> PyDLL:
    library.mj_factorM.argtypes, library.mj_factorM.restype = (c_void_p, c_void_p), None
    library.mj_rne.argtypes, library.mj_rne.restype = (c_void_p, c_void_p, c_int, c_void_p), None
    return library
