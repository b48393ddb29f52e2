"""Compiled: the plant's inner loops as machine code where Numba is installed, else as they stand."""

from collections.abc import Callable
from functools import cache
from typing import Any

from . import steps


def through() -> Callable[..., Any]:
    """`steps.through`, ten times as fast if it can be compiled."""
    return _quick(steps.through)


def torque() -> Callable[..., Any]:
    """`steps.torque`, likewise."""
    return _quick(steps.torque)


def fading() -> Callable[..., Any]:
    """`steps.fading`, likewise."""
    return _quick(steps.fading)


@cache
def _quick(function: Callable[..., Any]) -> Callable[..., Any]:
    compiler = _compiler()
    if compiler is None:
        return function
    try:
        return compiler(cache=True)(function)
    except RuntimeError:  # there is no folder to keep it in from process to process
        return compiler(function)


@cache
def _compiler() -> Callable[..., Any] | None:
    try:  # half a second, and only who simulates needs it
        from numba import njit
        from numba.extending import overload, register_jitable
    except ImportError:  # absent, or made for another NumPy
        return None
    overload(steps.solve, strict=False)(lambda matrix, right: steps.solve_by_hand)
    register_jitable(steps.springs)
    return njit
