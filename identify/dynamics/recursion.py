r"""Recursions of Newton and Euler on scalars, from ten parameters of each link about its frame's origin.

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

from ..effects.joint_state import JointState, Scalar
from .vectors import ZERO, Axis, Turn, Vector, add, cross, dot, scale, times


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
