"""Motion of every link of a tree, for many samples at once: the outward half of Newton-Euler.

Vectors are kept as (3, t), those of the m joints that move a link as (3, m, t), so that each operation
runs over contiguous samples.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from .motion import Motion


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


def links(kinematics: pin.Model, motion: Motion) -> list[Link]:
    """Every link in turn, from the base outward."""
    base = base_link(kinematics, len(motion))
    chain: list[Link] = []
    for index, joint in enumerate(joints_of(kinematics)):
        parent = base if joint.parent < 0 else chain[joint.parent]
        own = (every[:, index] for every in (motion.position, motion.velocity, motion.acceleration))
        chain.append(step(index, joint, parent, *own))
    return chain


def base_link(kinematics: pin.Model, samples: int) -> Link:
    """The base, at rest and held up against gravity."""
    still, nothing = np.zeros((3, samples)), np.zeros((3, 0, samples))
    rising = np.repeat(-np.array(kinematics.gravity.linear)[:, None], samples, axis=1)
    return Link(still, still, rising, [], nothing, nothing)


def fixed_joint(placement: pin.SE3) -> Joint:
    """A joint without an axis does not move: its frame is that of a body fixed to the link before."""
    return Joint(-1, placement, np.zeros(3), True)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cross product along the first axis; the others broadcast."""
    first = a[1] * b[2] - a[2] * b[1]
    out = np.empty((3, *first.shape))
    out[0] = first
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    return out


def step(
    index: int,
    joint: Joint,
    parent: Link,
    position: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
) -> Link:
    """The link behind a joint, whose motion is given in arrays of shape (t,)."""
    axis, still = joint.axis[:, None], 0.0 * position
    turn, slide = (position, still) if joint.revolute else (still, position)
    offset = joint.placement.translation[:, None] + joint.placement.rotation @ (axis * slide)
    inward = inward_rotation(joint, turn)
    spin = cross(parent.alpha, offset) + cross(parent.omega, cross(parent.omega, offset))
    # One product turns everything at once: three vectors of the link and two of each moving joint.
    linear = parent.linear + cross(parent.angular, offset[:, None])
    frame = np.stack([parent.omega, parent.alpha, parent.lift + spin], axis=1)
    turned = inward(np.concatenate([frame, linear, parent.angular], axis=1))
    omega, alpha, lift = turned[:, 0], turned[:, 1], turned[:, 2]
    linear, angular = np.split(turned[:, 3:], 2, axis=1)
    along = np.repeat(axis, len(position), axis=1)
    none = np.zeros_like(along)
    if joint.revolute:
        alpha = alpha + cross(omega, along * velocity) + along * acceleration
        omega = omega + along * velocity
    else:
        lift = lift + 2.0 * cross(omega, along * velocity) + along * acceleration
    new = (none, along) if joint.revolute else (along, none)
    linear, angular = (
        np.concatenate([old, one[:, None]], axis=1) for old, one in zip((linear, angular), new, strict=True)
    )
    return Link(omega, alpha, lift, [*parent.moving, index], linear, angular)


def inward_rotation(joint: Joint, turn: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Function that takes (3, m, t) vectors from the parent's frame into the link's (Rodrigues)."""
    axis, cosine, sine = joint.axis, np.cos(turn), np.sin(turn)
    across = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    to_placement = joint.placement.rotation.T
    along, beside = np.outer(axis, axis) @ to_placement, across @ to_placement
    every = np.concatenate([along, to_placement - along, beside])

    def inward(vector: np.ndarray) -> np.ndarray:
        parts = (every @ vector.reshape(3, -1)).reshape(3, *vector.shape)
        return parts[0] + parts[1] * cosine - parts[2] * sine

    return inward


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar product along the first axis."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
