"""Torque terms that simulators have in common, in addition to rigid bodies."""

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np


@dataclass(frozen=True, eq=False)
class JointTerms:
    """Torque terms of each joint in addition to its bodies, each of shape (n,).

    Attributes:
        armature: Inertia of rotor and gear [kg m^2].
        damping: Torque per velocity [N m s/rad].
        dry: Dry friction torque [N m].
        reversal: Velocity over which dry friction changes its sign, by tanh [rad/s].
        stiffness: Torque per position [N m/rad].
        constant: Torque at position zero [N m].
    """

    armature: np.ndarray
    damping: np.ndarray
    dry: np.ndarray
    reversal: np.ndarray
    stiffness: np.ndarray
    constant: np.ndarray

    @classmethod
    def of(cls, joints: int, **terms: np.ndarray) -> "JointTerms":
        """Joint terms with the given values, and zero for all others."""
        return cls(**{f.name: terms.get(f.name, np.zeros(joints)) for f in fields(cls)})

    def __add__(self, other: "JointTerms") -> "JointTerms":
        total = {f.name: getattr(self, f.name) + getattr(other, f.name) for f in fields(self)}
        # Simulators have one reversal velocity of dry friction: that of the larger part is used.
        total["reversal"] = np.where(other.dry >= self.dry, other.reversal, self.reversal)
        return JointTerms(**total)


class Spring(NamedTuple):
    """A spring from a point beside a joint's axis to a point of the link that the joint moves.

    Attributes:
        joint: Name of the joint.
        d21: Distance of the fixed end from the axis [m].
        d22: Distance of the moving end from the axis [m].
        phi: Angle between the two at joint position zero, zero where the spring is longest [rad].
        stiffness: Stiffness [N/m].
        preload: Preload [N].
    """

    joint: str
    d21: float
    d22: float
    phi: float
    stiffness: float
    preload: float
