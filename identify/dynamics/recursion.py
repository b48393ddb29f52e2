r"""Recursions of Newton and Euler on scalars, from ten parameters of each link about its frame's origin.

Scalars may be numbers, arrays of samples, or symbols; a vector is three of them.

Parameters enter linearly and need not be those of bodies that can exist: base parameters have links without
mass. With mass m, first moment h and inertia I of a link about its origin, angular velocity :math:`\omega`
and velocity v of the origin, and acceleration a minus gravity,

.. math:: f = m a + \dot\omega \times h + \omega \times (\omega \times h), \qquad
          n = I \dot\omega + \omega \times I \omega + h \times a .

The linear and angular momentum are :math:`m v + \omega \times h` and :math:`I \omega + h \times v`. A joint
with the unit twist S carries the momentum (l, k) of all links behind it, so that

.. math:: p_j = S \cdot (l, k), \qquad \frac{\partial T}{\partial q_j} = (V \times S) \cdot (l, k),

because a twist V of a link changes by the joint's motion as :math:`V \times S` (Featherstone, Rigid Body
Dynamics Algorithms, 2008). The second is :math:`C^T \dot q` (De Luca, Mattone 2003).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arm.newton_euler import Joint
from ..effects.joint_state import JointState, Scalar

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


class Body(NamedTuple):
    """Ten parameters of a link as scalars: inertia matrix and first moment about the origin, and mass."""

    inertia: Sequence[Vector]
    moment: Vector
    mass: Scalar

    @classmethod
    def of(cls, parameters: np.ndarray) -> "Body":
        """Body from parameters (10,) in `INERTIAL` order."""
        xx, xy, xz, yy, yz, zz, x, y, z, mass = map(float, parameters)
        return cls([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], [x, y, z], mass)


class Wrench(NamedTuple):
    """Force and moment about the origin of a frame, or linear and angular momentum."""

    linear: Vector
    angular: Vector


class Momentum(NamedTuple):
    """Generalized momentum of the joints, and derivative of the kinetic energy by their positions, n each."""

    momentum: Sequence[Scalar]
    by_position: Sequence[Scalar]


def _levers(joints: Sequence[Axis], state: JointState) -> list[Vector]:
    """Origin of each link in its parent's frame."""
    return [
        joint.place if joint.revolute else add(joint.place, scale(position, joint.slide))
        for joint, position in zip(joints, state.position, strict=True)
    ]


def _turned_inward(
    joints: Sequence[Axis], turns: Sequence[Turn], levers: Sequence[Vector], wrenches: Sequence[Wrench]
) -> list[Wrench]:
    """Wrench of each link and all links behind it, in the link's frame."""
    total = list(wrenches)
    for index in reversed(range(len(joints))):
        parent = joints[index].parent
        if parent >= 0:
            linear, angular = (turns[index].inward(vector) for vector in total[index])
            linear_sum, angular_sum = total[parent]
            about = add(angular, cross(levers[index], linear))
            total[parent] = Wrench(add(linear_sum, linear), add(angular_sum, about))
    return total


def link_torque(
    joints: Sequence[Axis], bodies: Sequence[Body], gravity: Vector, state: JointState
) -> list[Scalar]:
    """Torque of inertia, gravity, centrifugal and Coriolis forces, one scalar per joint [N m]."""
    turns = [Turn(joint, q) for joint, q in zip(joints, state.position, strict=True)]
    levers = _levers(joints, state)
    base = (ZERO, ZERO, scale(-1.0, gravity))
    motions: list[tuple[Vector, Vector, Vector]] = []
    for index, (joint, turn) in enumerate(zip(joints, turns, strict=True)):
        omega, alpha, lift = base if joint.parent < 0 else motions[joint.parent]
        lift = add(lift, _carried(omega, alpha, levers[index]))
        omega, alpha, lift = (turn.outward(vector) for vector in (omega, alpha, lift))
        turning, change = (
            scale(state.velocity[index], joint.axis),
            scale(state.acceleration[index], joint.axis),
        )
        relative = add(cross(omega, turning), change)
        if joint.revolute:
            omega, alpha = add(omega, turning), add(alpha, relative)
        else:
            lift = add(lift, relative, cross(omega, turning))
        motions.append((omega, alpha, lift))
    forces = [_force(body, *motion) for body, motion in zip(bodies, motions, strict=True)]
    return _along(joints, _turned_inward(joints, turns, levers, forces))


def _carried(omega: Vector, alpha: Vector, lever: Vector) -> Vector:
    """Acceleration of a point of a link, relative to the link's origin."""
    return add(cross(alpha, lever), cross(omega, cross(omega, lever)))


def _force(body: Body, omega: Vector, alpha: Vector, lift: Vector) -> Wrench:
    force = add(scale(body.mass, lift), _carried(omega, alpha, body.moment))
    spin = times(body.inertia, omega)
    return Wrench(force, add(times(body.inertia, alpha), cross(omega, spin), cross(body.moment, lift)))


def _along(joints: Sequence[Axis], wrenches: Sequence[Wrench]) -> list[Scalar]:
    """Component of each wrench along the joint."""
    return [
        dot(joint.axis, wrench.angular if joint.revolute else wrench.linear)
        for joint, wrench in zip(joints, wrenches, strict=True)
    ]


def link_momentum(joints: Sequence[Axis], bodies: Sequence[Body], state: JointState) -> Momentum:
    """Generalized momentum of the links [N m s], and the derivative of their kinetic energy [N m]."""
    turns = [Turn(joint, q) for joint, q in zip(joints, state.position, strict=True)]
    levers = _levers(joints, state)
    twists: list[tuple[Vector, Vector]] = []
    for index, (joint, turn) in enumerate(zip(joints, turns, strict=True)):
        omega, speed = (ZERO, ZERO) if joint.parent < 0 else twists[joint.parent]
        speed = turn.outward(add(speed, cross(omega, levers[index])))
        omega, turning = turn.outward(omega), scale(state.velocity[index], joint.axis)
        twists.append((add(omega, turning), speed) if joint.revolute else (omega, add(speed, turning)))
    momenta = [
        Wrench(
            add(scale(body.mass, speed), cross(omega, body.moment)),
            add(times(body.inertia, omega), cross(body.moment, speed)),
        )
        for body, (omega, speed) in zip(bodies, twists, strict=True)
    ]
    total = _turned_inward(joints, turns, levers, momenta)
    changes = []
    for joint, (omega, speed), (linear, angular) in zip(joints, twists, total, strict=True):
        across = cross(omega, joint.axis)
        if joint.revolute:
            changes.append(dot(across, angular) + dot(cross(speed, joint.axis), linear))
        else:
            changes.append(dot(across, linear))
    return Momentum(_along(joints, total), changes)
