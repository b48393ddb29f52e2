r"""Regressor of a tree of rigid bodies, for many samples at once.

Newton-Euler: with angular velocity :math:`\omega`, angular acceleration :math:`\dot\omega` and
acceleration minus gravity :math:`a` of a link's frame origin, all in that frame, its wrench is

.. math::
    f = m a + \dot\omega \times mc + \omega \times (\omega \times mc), \qquad
    \mu = I \dot\omega + \omega \times I \omega + mc \times a.

The torque of joint j that it needs is :math:`l \cdot f + z \cdot \mu`, where :math:`(l, z)` is the
velocity of that frame when joint j alone moves at 1 rad/s. Vectors are kept as (3, t), those of the m
joints that move a link as (3, m, t), so that each operation runs over contiguous samples.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

INERTIAL = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
"""The ten inertial parameters of a body about its frame's origin, in the paper's order (3)."""


@dataclass(frozen=True)
class Joint:
    """One joint of the tree: parent link (-1 for the base), placement there, axis, and kind."""

    parent: int
    placement: pin.SE3
    axis: np.ndarray
    revolute: bool


def joints_of(kinematics: pin.Model) -> list[Joint]:
    """The tree of a Pinocchio model whose joints have one degree of freedom each."""
    joints = []
    for index in range(1, kinematics.njoints):
        joint = kinematics.joints[index]
        data = joint.createData()
        joint.calc(data, np.zeros(kinematics.nq), np.zeros(kinematics.nv))
        motion = np.asarray(data.S, float).reshape(6)
        revolute = bool(np.any(motion[3:]))
        axis = motion[3:] if revolute else motion[:3]
        joints.append(Joint(kinematics.parents[index] - 1, kinematics.jointPlacements[index], axis, revolute))
    return joints


def rigid_regressor(
    kinematics: pin.Model,
    position: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    out: np.ndarray,
) -> np.ndarray:
    """Write joint torque per inertial parameter into `out`, which must be zero above the diagonal.

    Args:
        kinematics: Pinocchio model with n joints.
        position: Shape (t, n) [rad] or [m].
        velocity: Shape (t, n) [rad/s].
        acceleration: Shape (t, n) [rad/s^2].
        out: Zeros of shape (t, n, 10 n); columns are `INERTIAL` of link 1, of link 2 and so on.
    """
    for index, link in enumerate(_links(kinematics, position, velocity, acceleration)):
        _write(link, out[:, :, 10 * index : 10 * index + 10])
    return out


def body_regressor(
    kinematics: pin.Model,
    position: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    placement: pin.SE3,
) -> np.ndarray:
    """Joint torque per `INERTIAL` parameter of a body fixed to the last link, shape (t, n, 10).

    Args:
        kinematics: Pinocchio model with n joints.
        position: Shape (t, n) [rad] or [m].
        velocity: Shape (t, n) [rad/s].
        acceleration: Shape (t, n) [rad/s^2].
        placement: The body's frame in the last link's; the parameters are about its origin and axes.
    """
    last = _links(kinematics, position, velocity, acceleration)[-1]
    out = np.zeros((*position.shape, 10))
    # A joint without an axis does not move: its frame is the body's.
    fixed, still = Joint(kinematics.nv - 1, placement, np.zeros(3), True), np.zeros(len(position))
    body = _step(kinematics.nv, fixed, last, still, still, still)
    _write(replace(body, moving=last.moving), out)
    return out


@dataclass(frozen=True)
class Link:
    """Motion of a link's frame, in that frame.

    Attributes:
        omega: Angular velocity, shape (3, t) [rad/s].
        alpha: Angular acceleration, shape (3, t) [rad/s^2].
        lift: Acceleration of the origin minus gravity, shape (3, t) [m/s^2].
        moving: The m joints that move the frame.
        linear: Velocity of the origin when one of them moves at 1 rad/s, shape (3, m, t) [m/rad].
        angular: Angular velocity then, shape (3, m, t) [-].
    """

    omega: np.ndarray
    alpha: np.ndarray
    lift: np.ndarray
    moving: list[int]
    linear: np.ndarray
    angular: np.ndarray


def _links(
    kinematics: pin.Model, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
) -> list[Link]:
    """Every link in turn, from the base outward."""
    samples = len(position)
    still, nothing = np.zeros((3, samples)), np.zeros((3, 0, samples))
    rising = np.repeat(-np.array(kinematics.gravity.linear)[:, None], samples, axis=1)
    base = Link(still, still, rising, [], nothing, nothing)
    links: list[Link] = []
    for index, joint in enumerate(joints_of(kinematics)):
        parent = base if joint.parent < 0 else links[joint.parent]
        links.append(
            _step(index, joint, parent, position[:, index], velocity[:, index], acceleration[:, index])
        )
    return links


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cross product along the first axis; the others broadcast."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    return out


def _step(index: int, joint: Joint, parent: Link, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> Link:
    """The link behind a joint."""
    axis = joint.axis[:, None]
    turn, slide = (q, 0.0 * q) if joint.revolute else (0.0 * q, q)
    offset = joint.placement.translation[:, None] + joint.placement.rotation @ (axis * slide)
    inward = _inward_rotation(joint, turn)
    spin = _cross(parent.alpha, offset) + _cross(parent.omega, _cross(parent.omega, offset))
    # One product turns everything at once: three vectors of the link and two of each moving joint.
    linear = parent.linear + _cross(parent.angular, offset[:, None])
    frame = np.stack([parent.omega, parent.alpha, parent.lift + spin], axis=1)
    turned = inward(np.concatenate([frame, linear, parent.angular], axis=1))
    omega, alpha, lift = turned[:, 0], turned[:, 1], turned[:, 2]
    linear, angular = np.split(turned[:, 3:], 2, axis=1)
    along = np.repeat(axis, len(q), axis=1)
    none = np.zeros_like(along)
    if joint.revolute:
        alpha = alpha + _cross(omega, along * dq) + along * ddq
        omega = omega + along * dq
    else:
        lift = lift + 2.0 * _cross(omega, along * dq) + along * ddq
    new = (none, along) if joint.revolute else (along, none)
    linear, angular = (
        np.concatenate([old, one[:, None]], axis=1) for old, one in zip((linear, angular), new, strict=True)
    )
    return Link(omega, alpha, lift, [*parent.moving, index], linear, angular)


def _inward_rotation(joint: Joint, turn: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Function that takes (3, m, t) vectors from the parent's frame into the link's (Rodrigues)."""
    axis, cosine, sine = joint.axis, np.cos(turn), np.sin(turn)
    across = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    to_placement = joint.placement.rotation.T
    along, cross = np.outer(axis, axis) @ to_placement, across @ to_placement
    every = np.concatenate([along, to_placement - along, cross])

    def inward(vector: np.ndarray) -> np.ndarray:
        parts = (every @ vector.reshape(3, -1)).reshape(3, *vector.shape)
        return parts[0] + parts[1] * cosine - parts[2] * sine

    return inward


def _write(link: Link, out: np.ndarray) -> None:
    """Torque of every joint that moves a link per inertial parameter of it, into out (t, n, 10)."""
    omega, alpha, lift = (vector[:, None] for vector in (link.omega, link.alpha, link.lift))
    z, linear = link.angular, link.linear
    y = _cross(z, omega)
    columns = np.empty((10, *z.shape[1:]))
    for column, (i, j) in enumerate(((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))):
        np.multiply(z[i], alpha[j], out=columns[column])
        columns[column] += y[i] * omega[j]
        if i != j:
            columns[column] += z[j] * alpha[i]
            columns[column] += y[j] * omega[i]
    along = _dot(omega, linear)
    columns[6:9] = _cross(linear, alpha) + omega * along - linear * _dot(omega, omega) + _cross(lift, z)
    columns[9] = _dot(linear, lift)
    for place, moving in enumerate(link.moving):
        out[:, moving] = columns[:, place].T


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar product along the first axis."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
