"""Vectors of three scalars, which may be numbers, arrays of samples, or symbols."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arm.newton_euler import Joint
from ..effects.joint_state import Scalar

Vector = Sequence[Scalar]
ZERO: Vector = (0.0, 0.0, 0.0)
ROUNDING = 1e-15
"""Element of a rotation matrix below which it is a rounding error of an angle such as pi / 2 [-]."""


def add(*vectors: Vector) -> Vector:
    """Sum of vectors."""
    x, y, z = vectors[0]
    for vector in vectors[1:]:
        x, y, z = x + vector[0], y + vector[1], z + vector[2]
    return [x, y, z]


def scale(factor: Scalar, vector: Vector) -> Vector:
    """A scalar times a vector."""
    return [factor * part for part in vector]


def dot(a: Vector, b: Vector) -> Scalar:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Cross product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def times(matrix: Sequence[Vector], vector: Vector) -> Vector:
    """A matrix (3, 3) times a vector."""
    return [dot(row, vector) for row in matrix]


def numbers(array: np.ndarray) -> list:
    """Plain numbers of an array, with rounding errors of unit vectors and rotations set to zero."""
    return np.where(np.abs(array) < ROUNDING, 0.0, array).tolist()


class Axis(NamedTuple):
    """A joint as plain numbers."""

    parent: int  # index of the parent link; -1 for the base
    revolute: bool  # whether the joint turns; otherwise it slides
    axis: Vector  # axis in the link's frame
    place: Vector  # origin of the joint in the parent's frame [m]
    slide: Vector  # axis in the parent's frame
    inward: Sequence[Vector]  # rotation from the joint's frame into the parent's frame, at position zero
    outward: Sequence[Vector]  # rotation from the parent's frame into the joint's frame

    @classmethod
    def of(cls, joint: Joint) -> "Axis":
        """Numbers of a joint, without rounding errors of right angles."""
        turn = joint.placement.rotation
        parts = (joint.axis, joint.placement.translation, turn @ joint.axis, turn, turn.T)
        return cls(joint.parent, joint.revolute, *map(numbers, parts))


class Turn:
    """Rotation about a joint's axis, and then into the parent's frame.

    Args:
        joint: The joint; a prismatic joint does not turn.
        position: Joint position [rad].
    """

    def __init__(self, joint: Axis, position: Scalar) -> None:
        self._joint, self._cosine, self._sine = joint, 1.0, 0.0
        if joint.revolute:
            self._cosine, self._sine = plain(np.cos(position)), plain(np.sin(position))

    def outward(self, vector: Vector) -> Vector:
        """A vector of the parent's frame in the link's frame."""
        return self._about(times(self._joint.outward, vector), -self._sine)

    def inward(self, vector: Vector) -> Vector:
        """A vector of the link's frame in the parent's frame."""
        return times(self._joint.inward, self._about(vector, self._sine))

    def _about(self, vector: Vector, sine: Scalar) -> Vector:
        """The vector turned about the axis (Rodrigues)."""
        if not self._joint.revolute:
            return vector
        axis = self._joint.axis
        along = scale(dot(axis, vector), axis)
        across = [v - a for v, a in zip(vector, along, strict=True)]
        return add(along, scale(self._cosine, across), scale(sine, cross(axis, vector)))


def plain(value: Scalar) -> Scalar:
    """A Python number for a NumPy number, whose arithmetic takes three times as long; others unchanged."""
    return float(value) if isinstance(value, np.floating) else value
