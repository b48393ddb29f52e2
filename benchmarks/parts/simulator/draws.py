"""Sizes of concealed items: drawn for a joint, large enough to matter and no arm absurd."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from .physics import Item, Values


class Usual(NamedTuple):
    """What one joint of the original file does in a random motion."""

    torque: float  # RMS torque of the motor [N m]
    # Smallest torque that counts as friction of its size: the file's own, or a share of `torque` [N m]
    friction: float
    velocity: float  # RMS velocity [rad/s]
    inertia: float  # Inertia that the joint moves at the file's reference pose, with the rotor [kg m^2]


Draw = Callable[[np.random.Generator, Usual], Values]


def _factor(draw: np.random.Generator, lower: float, upper: float) -> float:
    """A factor between two, or its inverse."""
    return float(draw.uniform(lower, upper) ** draw.choice((-1.0, 1.0)))


DRAWS: dict[str, Draw] = {
    "delay": lambda draw, usual: {"seconds": draw.uniform(0.005, 0.045)},
    "kp": lambda draw, usual: {"factor": _factor(draw, 1.3, 2.0)},
    "kv": lambda draw, usual: {"factor": _factor(draw, 1.4, 2.0)},
    "forcerange": lambda draw, usual: {"saturated": draw.uniform(0.03, 0.06)},
    "coulomb": lambda draw, usual: {"frictionloss": draw.uniform(1.0, 2.0) * usual.friction},
    "viscous": lambda draw, usual: {"damping": draw.uniform(0.7, 1.5) * usual.friction / usual.velocity},
    "armature": lambda draw, usual: {"armature": draw.uniform(0.5, 1.0) * usual.inertia},
    "stribeck": lambda draw, usual: {
        "torque": draw.uniform(1.5, 2.5) * usual.friction, "velocity": draw.uniform(0.08, 0.2),
    },
    "load": lambda draw, usual: {"mu": draw.uniform(0.1, 0.25)},
    "thermal": lambda draw, usual: {
        "damping": draw.uniform(1.5, 2.5) * usual.friction / usual.velocity,
        "beta": draw.uniform(0.04, 0.06), "rise": draw.uniform(15.0, 25.0), "tau": draw.uniform(6.0, 10.0),
    },
    "cable": lambda draw, usual: {
        "stiffness": draw.uniform(0.8, 1.2) * usual.friction, "reference": draw.uniform(-0.5, 0.5),
        "ripple": draw.uniform(0.5, 1.0) * usual.friction, "waves": float(draw.integers(6, 12)),
    },
    "spring": lambda draw, usual: {
        "stiffness": draw.uniform(0.2, 0.4) * usual.torque, "reference": draw.uniform(-0.5, 0.5),
    },
    "mass": lambda draw, usual: {"factor": draw.uniform(1.25, 1.6)},
    "tilt": lambda draw, usual: {
        "angle": np.radians(draw.uniform(3.0, 6.0)), "direction": draw.uniform(-np.pi, np.pi),
    },
    "gravcomp": lambda draw, usual: {"share": draw.uniform(0.7, 0.85)},
}  # fmt: skip
"""Kind of an item -> how its values are drawn. A thermal arm loses half of its warm-up friction in a run."""


def drawn(kind: str, joints: tuple[int, ...], usual: list[Usual], draw: Any) -> Item:
    """An item with values of the size that suits its first joint."""
    return Item(kind, joints, DRAWS[kind](draw, usual[joints[0] if joints else 0]))
