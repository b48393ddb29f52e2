"""Literals of Python configuration files that other programs import."""

import re
from collections.abc import Iterable, Mapping
from textwrap import indent

import numpy as np

from exidyn.quoting import python_text

DIGITS = 6
"""Number of significant digits: solvers work in single precision."""


def number(value: float) -> str:
    """Literal of a number."""
    return repr(float(f"{value:.{DIGITS}g}"))


def patterns(joints: Iterable[str]) -> list[str]:
    """Literals of regular expressions that match exactly the joints' names."""
    return [python_text(re.escape(joint)) for joint in joints]


def by_joint(joints: Iterable[str], values: np.ndarray) -> str:
    """One number if all joints have the same value (n,), else a number for each with a finite value."""
    if np.all(values == values[0]):
        return number(values[0])
    pairs = zip(patterns(joints), values, strict=True)
    rows = "".join(f"    {pattern}: {number(value)},\n" for pattern, value in pairs if np.isfinite(value))
    return f"{{\n{rows}}}"


def steps(delay: float) -> str:
    """Number of physics steps of a delay [s], for a file that defines `PHYSICS_STEP`."""
    return f"round({number(delay)} / PHYSICS_STEP)"


def call(name: str, arguments: Mapping[str, str]) -> str:
    """Call of a function, with one argument per line."""
    rows = "\n".join(f"{key}={value}," for key, value in arguments.items())
    return f"{name}(\n{indent(rows, '    ')}\n)"
