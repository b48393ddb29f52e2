"""Motion of every link of a tree, for many samples at once: the outward half of Newton-Euler.

Vectors are kept as (3, t), those of the m joints that move a link as (3, m, t), so that each operation
runs over contiguous samples. Of the same tree, viewers need where each link is: the transforms of ROS's /tf.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from .motion import Motion

CACHED = 300
"""Samples up to which arrays of all links together stay in a processor's cache."""


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


class Pairs(NamedTuple):
    """Links, each with all joints that move it: p pairs, those of a link one after the other.

    Attributes:
        joints: Joint of each pair, shape (p,).
        links: Place of its link, shape (p,).
        omega: Angular velocity of the link, shape (3, p, t) or, of one link, (3, 1, t) [rad/s].
        alpha: Angular acceleration, of the same shape [rad/s^2].
        lift: Acceleration of the origin minus gravity, of the same shape [m/s^2].
        linear: Velocity of the origin when the joint moves at 1 rad/s, shape (3, p, t) [m/rad].
        angular: Angular velocity then, shape (3, p, t) [-].
    """

    joints: np.ndarray
    links: np.ndarray
    omega: np.ndarray
    alpha: np.ndarray
    lift: np.ndarray
    linear: np.ndarray
    angular: np.ndarray

    @classmethod
    def of(cls, chain: Sequence[Link]) -> "Pairs":
        """All pairs, so that each operation runs over all of them at once."""
        counts = [len(link.moving) for link in chain]
        places = np.repeat(np.arange(len(chain)), counts)
        omega, alpha, lift = (
            np.stack(every, axis=1)[:, places] if len(chain) > 1 else every[0][:, None]
            for every in zip(*((link.omega, link.alpha, link.lift) for link in chain), strict=True)
        )
        linear, angular = (
            np.concatenate([one[:, :count] for one, count in zip(every, counts, strict=True)], axis=1)
            if len(chain) > 1
            else every[0][:, : counts[0]]
            for every in zip(*((link.linear, link.angular) for link in chain), strict=True)
        )
        joints = np.concatenate([link.moving for link in chain]).astype(int)
        return cls(joints, places, omega, alpha, lift, linear, angular)


def cached_groups(chain: Sequence[Link]) -> Iterator[tuple[int, Sequence[Link]]]:
    """All links at once where their arrays stay in the cache, else one by one; each with its first place."""
    many = len(chain) if chain[0].omega.shape[1] <= CACHED else 1
    for first in range(0, len(chain), many):
        yield first, chain[first : first + many]


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


def skew(vector: np.ndarray) -> np.ndarray:
    """Matrix (3, 3) whose product with any vector is the cross product of this one (3,) with it."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def times(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """A matrix (k, 3) times vectors (3, m, t) or (3, t)."""
    return (matrix @ vectors.reshape(3, -1)).reshape(-1, *vectors.shape[1:])


def before(joint: Joint, slide: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Arm from parent to joint, slid by (t,) [m], crossed with the parent's vectors (3, m, t) or (3, t)."""
    found = times(skew(joint.placement.translation), vectors)
    if not joint.revolute:
        found += slide * times(skew(joint.placement.rotation @ joint.axis), vectors)
    return found


def step(
    index: int,
    joint: Joint,
    parent: Link,
    position: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
) -> Link:
    """The link behind a joint, whose motion is given in arrays of shape (t,)."""
    axis, count = joint.axis[:, None], len(parent.moving)
    # One product does everything at once: two vectors of the link and one of each moving joint.
    turning = np.concatenate([parent.omega[:, None], parent.alpha[:, None], parent.angular], axis=1)
    carried = before(joint, position, turning)
    lift = parent.lift - carried[:, 1] - cross(parent.omega, carried[:, 0])
    vectors = np.concatenate([turning, lift[:, None], parent.linear - carried[:, 2:]], axis=1)
    turned = inward(joint, position, vectors)
    omega, alpha, lift = turned[:, 0], turned[:, 1], turned[:, 2 + count]
    across = times(skew(joint.axis), omega)
    moved = np.zeros((2, 3, count + 1, len(position)))  # linear, angular
    moved[0, :, :count], moved[1, :, :count] = turned[:, 3 + count :], turned[:, 2 : 2 + count]
    moved[int(joint.revolute), :, count] = axis
    if joint.revolute:
        alpha = alpha - velocity * across + axis * acceleration
        omega = omega + axis * velocity
    else:
        lift = lift - 2.0 * velocity * across + axis * acceleration
    return Link(omega, alpha, lift, [*parent.moving, index], *moved)


def inward(joint: Joint, turn: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (3, m, t) of the parent's frame in the link's (Rodrigues)."""
    to_placement = joint.placement.rotation.T
    if not joint.revolute:
        return times(to_placement, vectors)
    along = np.outer(joint.axis, joint.axis) @ to_placement
    every = np.concatenate([along, to_placement - along, skew(joint.axis) @ to_placement])
    parts = times(every, vectors)
    return parts[:3] + parts[3:6] * np.cos(turn) - parts[6:] * np.sin(turn)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar product along the first axis."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


class LinkFrame(NamedTuple):
    """The frame that one joint moves.

    Attributes:
        parent: Name of the link before the joint.
        child: Name of the link behind it.
        placement: Joint's frame in the parent link's frame at zero position.
    """

    parent: str
    child: str
    placement: pin.SE3


def link_frames(kinematics: pin.Model) -> list[LinkFrame]:
    """One frame a joint; links are called as in the URDF, or link1, link2, … where there was none."""
    return [_link_frame(kinematics, index) for index in range(1, kinematics.njoints)]


def _link_frame(kinematics: pin.Model, joint: int) -> LinkFrame:
    placement = kinematics.jointPlacements[joint]
    place = kinematics.getFrameId(kinematics.names[joint], pin.FrameType.JOINT)
    if place == kinematics.nframes:  # the tree was built joint by joint, and its links have no names
        parent = kinematics.parents[joint]
        return LinkFrame(f"link{parent}" if parent else "base", f"link{joint}", placement)
    links = {frame.parentFrame: frame for frame in kinematics.frames if frame.type == pin.FrameType.BODY}
    carrier = kinematics.frames[kinematics.frames[place].parentFrame]
    child = links[place].name if place in links else f"link{joint}"
    return LinkFrame(carrier.name, child, carrier.placement.inverse() * placement)


def link_poses(kinematics: pin.Model, position: np.ndarray) -> np.ndarray:
    """Pose of each child link in its parent link, shape (t, n, 7): x y z [m], quaternion x y z w [-]."""
    poses = np.empty((*position.shape, 7))
    frames = link_frames(kinematics)
    for index, (joint, frame) in enumerate(zip(joints_of(kinematics), frames, strict=True)):
        place, turn = frame.placement, pin.Quaternion(frame.placement.rotation).coeffs()
        moved = position[:, index, None]
        if joint.revolute:
            poses[:, index, :3] = place.translation
            poses[:, index, 3:] = _turned(turn, _about(joint.axis, moved))
        else:
            poses[:, index, :3] = place.translation + moved * (place.rotation @ joint.axis)
            poses[:, index, 3:] = turn
    return poses


def flange_position(
    kinematics: pin.Model, flange: pin.SE3, position: np.ndarray, data: pin.Data | None = None
) -> np.ndarray:
    """Where the flange is in the base frame at a position (n,), shape (3,) [m]; `data` is computed in."""
    data = data or kinematics.createData()
    pin.forwardKinematics(kinematics, data, position)
    place: np.ndarray = (data.oMi[kinematics.njoints - 1] * flange).translation
    return place.copy()


def _about(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore"):  # a joint that is at no number, as recorded, points nowhere
        return np.concatenate([axis * np.sin(angle / 2), np.cos(angle / 2)], axis=1)


def _turned(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Product of one quaternion with many, x y z w."""
    x, y, z, w = left
    by_right = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])
    return right @ by_right.T
