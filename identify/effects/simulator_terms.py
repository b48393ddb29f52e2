"""Torque terms that simulators have in common, in addition to rigid bodies."""

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np


@dataclass(frozen=True, eq=False)
class JointTerms:
    """Torque terms of each joint in addition to its bodies, each of shape (n,)."""

    armature: np.ndarray  # inertia of rotor and gear [kg m^2]
    damping: np.ndarray  # torque per velocity [N m s/rad]
    dry: np.ndarray  # dry friction torque [N m]
    reversal: np.ndarray  # velocity over which dry friction changes its sign, by tanh [rad/s]
    stiffness: np.ndarray  # torque per position [N m/rad]
    constant: np.ndarray  # torque at position zero [N m]

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
    """A spring from a point beside a joint's axis to a point of the link that the joint moves."""

    joint: str  # name of the joint
    d21: float  # distance of the fixed end from the axis [m]
    d22: float  # distance of the moving end from the axis [m]
    phi: float  # angle between the two at joint position zero, zero where the spring is longest [rad]
    stiffness: float  # stiffness [N/m]
    preload: float  # preload [N]
