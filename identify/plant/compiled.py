"""Compiled: the plant's inner loop as machine code where Numba is installed, else as it stands."""

from collections.abc import Callable
from functools import cache
from typing import Any

from . import steps


@cache
def through() -> Callable[..., Any]:
    """`steps.through`, ten times as fast if it can be compiled."""
    try:  # half a second, and only who simulates needs it
        from numba import njit
        from numba.extending import overload, register_jitable
    except ImportError:  # absent, or made for another NumPy
        return steps.through
    overload(steps.solve, strict=False)(lambda matrix, right: steps.solve_by_hand)
    register_jitable(steps.springs)
    try:
        return njit(cache=True)(steps.through)
    except RuntimeError:  # there is no folder to keep it in from process to process
        return njit(steps.through)
