"""`JointState`: state of all joints, one scalar per joint and quantity."""

from collections.abc import Sequence
from typing import Any, NamedTuple

Scalar = Any
"""A number, an array of samples (t,), or a symbol of a program that is being written."""


class JointState(NamedTuple):
    """State of n joints, each field a sequence of n scalars.

    Attributes:
        position: Joint position [rad], or [m] for prismatic joints.
        velocity: Joint velocity [rad/s].
        acceleration: Joint acceleration [rad/s^2].
        load: Nominal torque that the gear transmits to the link [N m].
        temperature: Temperature [degC].
    """

    position: Sequence[Scalar]
    velocity: Sequence[Scalar]
    acceleration: Sequence[Scalar]
    load: Sequence[Scalar]
    temperature: Sequence[Scalar]

    @property
    def still(self) -> "JointState":
        """The state at the same positions without velocity and acceleration."""
        zeros = [0.0] * len(self.position)
        return self._replace(velocity=zeros, acceleration=zeros)
