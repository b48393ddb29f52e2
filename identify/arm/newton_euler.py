"""Motion of all links of a tree for many samples at once: the outward recursion of Newton-Euler.

Vectors have shape (3, t), and those of the m joints that move a link (3, m, t), so that each operation runs
over contiguous samples. The module also computes link poses for viewers: the transforms of ROS's /tf.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from .motion import Motion

CACHED = 300
"""Number of samples up to which the arrays of all links fit into the processor cache."""


@dataclass(frozen=True)
class Joint:
    """One joint of the tree: parent link (-1 for the base), placement in it, axis, and kind."""

    parent: int
    placement: pin.SE3
    axis: np.ndarray
    revolute: bool


def joints_of(kinematics: pin.Model) -> list[Joint]:
    """Joints of a Pinocchio model in which each joint has one degree of freedom."""
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
    """Motion of a link's frame, in that frame."""

    omega: np.ndarray  # angular velocity, shape (3, t) [rad/s]
    alpha: np.ndarray  # angular acceleration, shape (3, t) [rad/s^2]
    lift: np.ndarray  # acceleration of the origin minus gravity, shape (3, t) [m/s^2]
    moving: list[int]  # indices of the m joints that move the frame
    # Velocity of the origin per unit velocity of each of these joints, shape (3, m, t) [m/rad].
    linear: np.ndarray
    angular: np.ndarray  # angular velocity per unit velocity of each of these joints, shape (3, m, t) [-]


def links(kinematics: pin.Model, motion: Motion) -> list[Link]:
    """Motion of all links, from the base outward."""
    base = base_link(kinematics, len(motion))
    chain: list[Link] = []
    for index, joint in enumerate(joints_of(kinematics)):
        parent = base if joint.parent < 0 else chain[joint.parent]
        state = (values[:, index] for values in (motion.position, motion.velocity, motion.acceleration))
        chain.append(step(index, joint, parent, *state))
    return chain


class Pairs(NamedTuple):
    """All p pairs of a link and a joint that moves it, ordered by link."""

    joints: np.ndarray  # joint of each pair, shape (p,)
    links: np.ndarray  # index of the link of each pair, shape (p,)
    omega: np.ndarray  # angular velocity of the link, shape (3, p, t), or (3, 1, t) for a single link [rad/s]
    alpha: np.ndarray  # angular acceleration, same shape as omega [rad/s^2]
    lift: np.ndarray  # acceleration of the origin minus gravity, same shape as omega [m/s^2]
    linear: np.ndarray  # velocity of the origin per unit velocity of the joint, shape (3, p, t) [m/rad]
    angular: np.ndarray  # angular velocity per unit velocity of the joint, shape (3, p, t) [-]

    @classmethod
    def of(cls, chain: Sequence[Link]) -> "Pairs":
        """Pairs of all links, for operations on all of them at once."""
        counts = [len(link.moving) for link in chain]
        places = np.repeat(np.arange(len(chain)), counts)
        omega, alpha, lift = (
            np.stack(vectors, axis=1)[:, places] if len(chain) > 1 else vectors[0][:, None]
            for vectors in zip(*((link.omega, link.alpha, link.lift) for link in chain), strict=True)
        )
        linear, angular = (
            np.concatenate([array[:, :count] for array, count in zip(arrays, counts, strict=True)], axis=1)
            if len(chain) > 1
            else arrays[0][:, : counts[0]]
            for arrays in zip(*((link.linear, link.angular) for link in chain), strict=True)
        )
        joints = np.concatenate([link.moving for link in chain]).astype(int)
        return cls(joints, places, omega, alpha, lift, linear, angular)


def cached_groups(chain: Sequence[Link]) -> Iterator[tuple[int, Sequence[Link]]]:
    """All links at once if their arrays fit into the cache, else one by one; each with its first index."""
    many = len(chain) if chain[0].omega.shape[1] <= CACHED else 1
    for first in range(0, len(chain), many):
        yield first, chain[first : first + many]


def base_link(kinematics: pin.Model, samples: int) -> Link:
    """The base: at rest, with an upward acceleration that represents gravity."""
    still, nothing = np.zeros((3, samples)), np.zeros((3, 0, samples))
    rising = np.repeat(-np.array(kinematics.gravity.linear)[:, None], samples, axis=1)
    return Link(still, still, rising, [], nothing, nothing)


def fixed_joint(placement: pin.SE3) -> Joint:
    """Joint without an axis, for the frame of a body fixed to the preceding link."""
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
    """Matrix (3, 3) whose product with a vector v is the cross product of `vector` (3,) and v."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def times(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """A matrix (k, 3) times vectors (3, m, t) or (3, t)."""
    return (matrix @ vectors.reshape(3, -1)).reshape(-1, *vectors.shape[1:])


def lever_cross(joint: Joint, slide: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Cross product of the lever from parent to joint with the parent's vectors (3, m, t) or (3, t).

    A prismatic joint extends the lever by `slide`, shape (t,) [m].
    """
    product = times(skew(joint.placement.translation), vectors)
    if not joint.revolute:
        product += slide * times(skew(joint.placement.rotation @ joint.axis), vectors)
    return product


def step(
    index: int,
    joint: Joint,
    parent: Link,
    position: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
) -> Link:
    """Motion of the link behind a joint, from position, velocity and acceleration of the joint, each (t,)."""
    axis, count = joint.axis[:, None], len(parent.moving)
    # A single product handles two vectors of the link and one of each moving joint.
    turning = np.concatenate([parent.omega[:, None], parent.alpha[:, None], parent.angular], axis=1)
    carried = lever_cross(joint, position, turning)
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
    """Vectors (3, m, t) transformed from the parent's to the link's frame (Rodrigues)."""
    to_placement = joint.placement.rotation.T
    if not joint.revolute:
        return times(to_placement, vectors)
    along = np.outer(joint.axis, joint.axis) @ to_placement
    rotations = np.concatenate([along, to_placement - along, skew(joint.axis) @ to_placement])
    parts = times(rotations, vectors)
    return parts[:3] + parts[3:6] * np.cos(turn) - parts[6:] * np.sin(turn)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar product along the first axis."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


class LinkFrame(NamedTuple):
    """The frame that one joint moves."""

    parent: str  # name of the link before the joint
    child: str  # name of the link behind the joint
    placement: pin.SE3  # frame of the joint in the frame of the parent link at zero position


def link_frames(kinematics: pin.Model) -> list[LinkFrame]:
    """One frame per joint; links have the names of the URDF, or link1, link2, … without a URDF."""
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
    """Position of the flange in the base frame, shape (3,) [m], at joint positions (n,); `data` is reused."""
    data = data or kinematics.createData()
    pin.forwardKinematics(kinematics, data, position)
    place: np.ndarray = (data.oMi[kinematics.njoints - 1] * flange).translation
    return place.copy()


def _about(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore"):  # recorded positions may be NaN
        return np.concatenate([axis * np.sin(angle / 2), np.cos(angle / 2)], axis=1)


def _turned(quaternion: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Product of one quaternion with many, in the order x y z w."""
    x, y, z, w = quaternion
    by_right = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])
    return right @ by_right.T
