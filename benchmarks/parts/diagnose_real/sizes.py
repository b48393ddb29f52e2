"""Sizes and places of findings in words."""

from collections.abc import Sequence

import numpy as np

from exidyn.identification.diagnosis.findings.finding import Finding

from .known import numbers

DERIVED = {"amplitude": "N m", "gear stiffness": "N m/rad", "harmonic": "1"}
"""Units of numbers that follow from others."""
STUCK = 1e-9
"""Standard deviation of a number that its limit holds, at most, as a part of the number or of one [-]."""


def size(one: Finding) -> str:
    """Coefficients and shape of a finding that are determined, with one standard deviation.

    Where some are not, what no other parameter can take over of its torque, root mean square.
    """
    units = {name: q.unit for name, q in one.parameters.items()} | DERIVED
    stated = {name: pair for name, pair in numbers(one).items() if name in units and name not in one.left_out}
    words = [number(name, *pair, units[name]) for name, pair in stated.items()]
    if one.left_out and one.size is not None:
        words.append(number("torque", one.size.beside_rms, one.size.beside_std, "N m"))
    return ", ".join(words)


def number(name: str, value: float, std: float, unit: str) -> str:
    """One number; of what is at a limit of its range the deviation says nothing."""
    unit = "" if unit == "1" else f" {unit}"
    if std < STUCK * max(abs(value), 1.0):
        return f"{name} {value:.4g}{unit} (at its limit, not measured)"
    return f"{name} {value:.4g}{f' ± {std:.2g}' if np.isfinite(std) else ''}{unit}"


def joints_words(joints: Sequence[int]) -> str:
    """J2 J3; a dash for the whole arm."""
    return " ".join(f"J{joint + 1}" for joint in joints) or "-"
