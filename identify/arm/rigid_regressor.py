r"""Regressor of a tree of rigid bodies for many samples at once, and its gradient by the motion.

Newton-Euler: with angular velocity :math:`\omega`, angular acceleration :math:`\dot\omega` and
acceleration minus gravity :math:`a` of a link's frame origin, all in that frame, its wrench is

.. math::
    f = m a + \dot\omega \times mc + \omega \times (\omega \times mc), \qquad
    \mu = I \dot\omega + \omega \times I \omega + mc \times a.

The torque of joint j for it is :math:`l \cdot f + z \cdot \mu`, where :math:`(l, z)` is the velocity of that
frame when only joint j moves at 1 rad/s. Vectors have shape (3, t), and those of the m joints that move a
link (3, m, t), so that each operation runs over contiguous samples.

For weights :math:`g`, the sum :math:`\sum g_{tjc} Y_{tjc}(q, \dot q, \ddot q)` over a regressor is
differentiated by a backward pass: each link passes the derivative of the sum with respect to its parent's
motion to the parent. One pass costs about as much as three regressors, regardless of the number of
parameters.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
import pinocchio as pin

from .motion import Motion
from .newton_euler import (
    Joint,
    Link,
    Pairs,
    base_link,
    cached_groups,
    cross,
    dot,
    fixed_joint,
    joints_of,
    lever_cross,
    links,
    skew,
    step,
    times,
)

INERTIAL = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
"""The ten inertial parameters of a body about the origin of its frame, in the order of the paper's (3)."""


def rigid_regressor(kinematics: pin.Model, motion: Motion) -> np.ndarray:
    """Joint torque per inertial parameter, shape (t, n, 10 n): `INERTIAL` of link 1, of link 2, etc."""
    out = np.zeros((*motion.position.shape, kinematics.nv, 10))
    _write(links(kinematics, motion), out)
    return out.reshape(*motion.position.shape, -1)


def body_regressor(kinematics: pin.Model, motion: Motion, placement: pin.SE3) -> np.ndarray:
    """Joint torque per `INERTIAL` parameter of a body fixed to the last link, shape (t, n, 10).

    The parameters refer to `placement`, a frame in that of the last link.
    """
    last, still = links(kinematics, motion)[-1], np.zeros(len(motion))
    body = step(kinematics.nv, fixed_joint(placement), last, still, still, still)
    out = np.zeros((*motion.position.shape, 1, 10))
    _write([replace(body, moving=last.moving)], out)
    return out[:, :, 0]


def _write(chain: Sequence[Link], out: np.ndarray) -> None:
    """Write the torque of every joint per inertial parameter of some links to `out` (t, n, links, 10)."""
    for first, some in cached_groups(chain):
        pairs = Pairs.of(some)
        out[:, pairs.joints, first + pairs.links] = _columns(pairs).T


def _columns(pairs: Pairs) -> np.ndarray:
    """Torque per inertial parameter of each pair of link and joint, shape (10, p, t)."""
    omega, alpha, lift, linear, z = pairs[2:]
    y = cross(z, omega)
    columns = np.empty((10, *z.shape[1:]))
    for column, (i, j) in enumerate(((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))):
        np.multiply(z[i], alpha[j], out=columns[column])
        columns[column] += y[i] * omega[j]
        if i != j:
            columns[column] += z[j] * alpha[i]
            columns[column] += y[j] * omega[i]
    along = dot(omega, linear)
    columns[6:9] = cross(linear, alpha) + omega * along - linear * dot(omega, omega) + cross(lift, z)
    columns[9] = dot(linear, lift)
    return columns


@dataclass(frozen=True)
class _Pull:
    """Derivative of the sum with respect to a link's motion, with fields and shapes as in `Link`."""

    omega: np.ndarray
    alpha: np.ndarray
    lift: np.ndarray
    linear: np.ndarray
    angular: np.ndarray

    def __add__(self, other: "_Pull") -> "_Pull":
        pairs = ((getattr(self, f.name), getattr(other, f.name)) for f in fields(self))
        return _Pull(*(a + b for a, b in pairs))


def rigid_gradient(kinematics: pin.Model, motion: Motion, weights: np.ndarray) -> np.ndarray:
    """Derivatives of sum(weights * rigid regressor), shape (3, t, n), for weights (t, n, 10 n).

    They are with respect to position, velocity and acceleration.
    """
    chain = links(kinematics, motion)
    weights = weights.reshape(*motion.position.shape, -1, 10)
    pulls = [
        pull
        for first, some in cached_groups(chain)
        for pull in _read(some, weights[:, :, first : first + len(some)])
    ]
    return _to_base(kinematics, chain, pulls, motion)


def body_gradient(kinematics: pin.Model, motion: Motion, flange: pin.SE3, weights: np.ndarray) -> np.ndarray:
    """Derivatives as of `rigid_gradient` for a body fixed to the last link, with weights (t, n, 10)."""
    chain = links(kinematics, motion)
    fixed, still = fixed_joint(flange), np.zeros(len(motion))
    body = step(len(chain), fixed, chain[-1], still, still, still)
    [pull] = _read([replace(body, moving=chain[-1].moving)], weights[:, :, None])
    pulls = [_nothing(link) for link in chain]
    pulls[-1] = _step_back(fixed, chain[-1], body, pull, still, still)[0]
    return _to_base(kinematics, chain, pulls, motion)


def _to_base(kinematics: pin.Model, chain: list[Link], pulls: list[_Pull], motion: Motion) -> np.ndarray:
    """Propagate the pulls from tip to base, adding each link's pull to its parent's; returns derivatives."""
    by = np.zeros((3, *motion.position.shape))
    base = base_link(kinematics, len(motion))
    joints = joints_of(kinematics)
    for index in range(len(chain) - 1, -1, -1):
        joint = joints[index]
        parent = base if joint.parent < 0 else chain[joint.parent]
        turn, rate = motion.position[:, index], motion.velocity[:, index]
        pull, by[:, :, index] = _step_back(joint, parent, chain[index], pulls[index], turn, rate)
        if joint.parent >= 0:
            pulls[joint.parent] = pulls[joint.parent] + pull
    return by


def _nothing(link: Link) -> _Pull:
    return _Pull(*(np.zeros_like(v) for v in (link.omega, link.alpha, link.lift, link.linear, link.angular)))


def _read(chain: Sequence[Link], weights: np.ndarray) -> list[_Pull]:
    """Pull of each link's columns for weights (t, n, links, 10); the adjoint of `_write`."""
    pairs = Pairs.of(chain)
    pull = np.ascontiguousarray(weights[:, pairs.joints, pairs.links].T)
    omega, alpha, lift, linear, z = pairs[2:]
    y = cross(z, omega)
    by_z, by_y = _turn(pull, alpha), _turn(pull, omega)
    first, mass = pull[6:9], pull[9]
    across, along, swing = dot(first, linear), dot(omega, linear), dot(first, omega)
    by_omega = _turn(pull, y) + cross(by_y, z) + first * along + linear * swing - 2.0 * omega * across
    by_alpha = _turn(pull, z) + cross(first, linear)
    by_lift = cross(z, first) + mass * linear
    by_linear = cross(alpha, first) + omega * swing - first * dot(omega, omega) + mass * lift
    by_angular = by_z + cross(omega, by_y) + cross(first, lift)
    starts = np.flatnonzero(np.diff(pairs.links, prepend=-1))
    summed = (np.add.reduceat(part, starts, axis=1) for part in (by_omega, by_alpha, by_lift))
    split = (np.split(part, starts[1:], axis=1) for part in (by_linear, by_angular))
    return list(map(_Pull, *(part.swapaxes(0, 1) for part in summed), *split))


def _turn(pull: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Symmetric matrix of the six inertia weights times a vector, all (3, m, t)."""
    xx, xy, xz, yy, yz, zz = pull[:6]
    x, y, z = vector
    return np.stack([xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z])


def _step_back(
    joint: Joint, parent: Link, link: Link, pull: _Pull, turn: np.ndarray, rate: np.ndarray
) -> tuple[_Pull, np.ndarray]:
    """Pull on the parent, and derivatives by the joint's position, velocity, acceleration, shape (3, t)."""
    axis, turning, count = joint.axis, skew(joint.axis), len(parent.moving)
    across = times(turning, link.omega)
    if joint.revolute:  # undo the contribution of the joint's own motion
        by_omega, alpha = pull.omega + rate * times(turning, pull.alpha), link.alpha + rate * across
        by_rate, by_change = axis @ pull.omega - dot(pull.alpha, across), axis @ pull.alpha
    else:
        by_omega, alpha = pull.omega + 2.0 * rate * times(turning, pull.lift), link.alpha
        by_rate, by_change = -2.0 * dot(pull.lift, across), axis @ pull.lift
    pulls = _side_by_side(by_omega, pull.alpha, pull.lift, pull.linear[:, :count], pull.angular[:, :count])
    outer = _outward(joint, turn, pulls)
    up, by_arm = _parent_pull(joint, parent, turn, outer)
    if joint.revolute:
        frame = (link.omega, alpha, link.lift, link.linear[:, :count], link.angular[:, :count])
        by_position = -np.einsum("cmt,cmt->t", times(turning, _side_by_side(*frame)), pulls)
    else:
        by_position = (joint.placement.rotation @ axis) @ by_arm
    return up, np.stack([by_position, by_rate, by_change])


def _side_by_side(
    omega: np.ndarray, alpha: np.ndarray, lift: np.ndarray, linear: np.ndarray, angular: np.ndarray
) -> np.ndarray:
    """Concatenate three vectors (3, t) and two arrays (3, m, t) to shape (3, 3 + 2 m, t)."""
    return np.concatenate([np.stack([omega, alpha, lift], axis=1), linear, angular], axis=1)


def _outward(joint: Joint, turn: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (3, m, t) transformed from the link's to the parent's frame."""
    back = joint.placement.rotation
    if not joint.revolute:
        return times(back, vectors)
    along = back @ np.outer(joint.axis, joint.axis)
    parts = times(np.concatenate([along, back - along, back @ skew(joint.axis)]), vectors)
    return parts[:3] + parts[3:6] * np.cos(turn) + parts[6:] * np.sin(turn)


def _parent_pull(
    joint: Joint, parent: Link, slide: np.ndarray, pulls: np.ndarray
) -> tuple[_Pull, np.ndarray]:
    """Pull on a parent from that on the vectors at a joint, and derivative by the lever to it, (3, t).

    The vectors at the joint are omega, alpha, lift + alpha x lever + omega x (omega x lever),
    linear + angular x lever, angular.
    """
    by_omega, by_alpha, by_lift = pulls[:, 0], pulls[:, 1], pulls[:, 2]
    linear, angular = np.split(pulls[:, 3:], 2, axis=1)
    spin = cross(by_lift, parent.omega)
    vectors = np.concatenate([np.stack([by_lift, spin, parent.omega], axis=1), linear], axis=1)
    levered = lever_cross(joint, slide, vectors)
    by_omega = by_omega + cross(by_lift, levered[:, 2]) + levered[:, 1]
    pull = _Pull(by_omega, by_alpha + levered[:, 0], by_lift, linear, angular + levered[:, 3:])
    if joint.revolute:  # constant lever
        return pull, np.zeros_like(spin)
    by_arm = cross(by_lift, parent.alpha) + cross(spin, parent.omega) + cross(linear, parent.angular).sum(1)
    return pull, by_arm
