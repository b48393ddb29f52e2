"""Where the joints are, for many samples at once, and how a point's coordinate answers to each joint."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from exidyn.identify.arm.newton_euler import Joint


class Poses(NamedTuple):
    """Frames that the joints move, in the base frame.

    Attributes:
        rotation: Shape (t, n, 3, 3).
        origin: Shape (t, n, 3) [m].
        axis: Direction that each joint revolute about or slides along, shape (t, n, 3).
    """

    rotation: np.ndarray
    origin: np.ndarray
    axis: np.ndarray


def joint_poses(joints: list[Joint], position: np.ndarray) -> Poses:
    """Poses at joint positions of shape (t, n) [rad] or [m]."""
    count = len(position)
    rotation, origin = np.empty((count, len(joints), 3, 3)), np.empty((count, len(joints), 3))
    axis = np.empty((count, len(joints), 3))
    for index, joint in enumerate(joints):
        carrier, place = np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3))
        if joint.parent >= 0:
            carrier, place = rotation[:, joint.parent], origin[:, joint.parent]
        still = carrier @ joint.placement.rotation
        axis[:, index] = still @ joint.axis
        rotation[:, index] = still @ _turned(joint, position[:, index]) if joint.revolute else still
        origin[:, index] = place + carrier @ joint.placement.translation
        if not joint.revolute:
            origin[:, index] += position[:, index, None] * axis[:, index]
    return Poses(rotation, origin, axis)


def _turned(joint: Joint, angle: np.ndarray) -> np.ndarray:
    """Rotation about the joint's axis by Rodrigues' formula, shape (t, 3, 3)."""
    across = pin.skew(joint.axis)
    sine, cosine = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + sine * across + (1.0 - cosine) * (across @ across)


def slopes(joints: list[Joint], poses: Poses, point: np.ndarray, direction: np.ndarray) -> np.ndarray:
    r"""How far a point moves along a direction as each joint alone moves, were it fixed to its link.

    For a joint about axis a through o this is :math:`d \cdot (a \times (p - o))`
    :math:`= (p \times d) \cdot a - d \cdot (a \times o)`: two matrix products a sample.

    Args:
        joints: The n joints.
        poses: Where they are.
        point: In the base frame, shape (t, m, 3) [m].
        direction: In the base frame, shape (t, m, 3) [-].

    Returns:
        Shape (t, m, n) [m/rad], or [m/m] where the joint slides.
    """
    revolute = np.array([joint.revolute for joint in joints])
    along = np.swapaxes(poses.axis, 1, 2)
    moment = np.swapaxes(np.cross(poses.axis, poses.origin), 1, 2)
    turning = np.cross(point, direction) @ along - direction @ moment
    return np.where(revolute, turning, direction @ along)


def moves(joints: list[Joint], body: int) -> np.ndarray:
    """Which joints carry a body, shape (n,) of bool; body -1 is the base, j what joint j moves."""
    carried = np.zeros(len(joints), bool)
    while body >= 0:
        carried[body] = True
        body = joints[body].parent
    return carried
