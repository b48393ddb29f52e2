"""`JointState`: state of all joints, one scalar per joint and quantity."""

from collections.abc import Sequence
from typing import Any, NamedTuple

Scalar = Any
"""A number, an array of samples (t,), or a symbol of a program that is being written."""


class JointState(NamedTuple):
    """State of n joints, each field a sequence of n scalars."""

    position: Sequence[Scalar]  # joint position [rad], or [m] for prismatic joints
    velocity: Sequence[Scalar]  # joint velocity [rad/s]
    acceleration: Sequence[Scalar]  # joint acceleration [rad/s^2]
    load: Sequence[Scalar]  # nominal torque that the gear transmits to the link [N m]
    temperature: Sequence[Scalar]  # temperature [degC]

    @property
    def still(self) -> "JointState":
        """The state at the same positions without velocity and acceleration."""
        zeros = [0.0] * len(self.position)
        return self._replace(velocity=zeros, acceleration=zeros)
