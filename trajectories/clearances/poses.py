"""Where joints are, how a point answers to each joint, and how far from its axis a body can get."""

from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.newton_euler import Joint


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


class Cover(NamedTuple):
    """Points whose convex hull holds a body, or its core where it is that and a radius all around.

    A distance from a ball is that from its centre less a constant, so its radius changes no bound.

    Attributes:
        body: The joint that carries it, -1 for the base.
        points: In that joint's frame, shape (k, 3) [m].
    """

    body: int
    points: np.ndarray


FAR = 1e6
"""A point of a half-space, which has no end [m]: of a pair's two bounds that of the other body then holds."""


def cover(body: pin.GeometryObject) -> Cover:
    """Cover of a body of the collision geometry."""
    shape = body.geometry
    kind = type(shape).__name__
    if kind.startswith("Convex"):
        points = np.array(shape.points(), float).reshape(-1, 3)
    elif kind in ("Sphere", "Capsule"):
        half = shape.halfLength if kind == "Capsule" else 0.0
        points = np.array([[0.0, 0.0, -half], [0.0, 0.0, half]])
    elif kind == "Halfspace":
        points = np.full((1, 3), FAR)
    else:
        points = _box(shape)
    points = points @ body.placement.rotation.T + body.placement.translation
    return Cover(body.parentJoint - 1, points)


def _box(shape: Any) -> np.ndarray:
    """Corners of the box around a shape, shape (8, 3) [m]."""
    shape.computeLocalAABB()
    ends = np.stack([shape.aabb_local.min_, shape.aabb_local.max_])
    return np.stack(np.meshgrid(*ends.T, indexing="ij"), axis=-1).reshape(-1, 3)


def reach(joints: list[Joint], joint: int, cover: Cover, travel: np.ndarray) -> float:
    """Largest distance of a body's points from a joint's axis over all positions [m].

    The path from the axis to the body through the joints between is at most this long: on each link
    from where it is entered to where it is left. So the body moves past the axis, as seen from the other
    side of the joint, at no more than this times the joint's velocity.

    Args:
        joints: The n joints.
        joint: Whose axis.
        cover: The body.
        travel: Largest distance from zero of the joints that slide, shape (n,) [m].

    Returns:
        1 for a joint that slides: what it moves is as fast as itself.
    """
    own = joints[joint]
    if not own.revolute:
        return 1.0
    down = bool(moves(joints, cover.body)[joint])
    entry, axis = (np.zeros(3), own.axis)
    if not down:
        entry, axis = own.placement.translation, own.placement.rotation @ own.axis
    here, length = joint if down else own.parent, 0.0
    across: np.ndarray | None = axis
    for step in _path(joints, here, cover.body):
        deeper = step >= 0 and joints[step].parent == here
        crossed = step if deeper else here
        hinge = joints[crossed].placement.translation
        length += _gap(entry, across, (hinge if deeper else np.zeros(3))[None])
        length += 0.0 if joints[crossed].revolute else float(travel[crossed])
        here, entry, across = step, (np.zeros(3) if deeper else hinge), None
    return length + _gap(entry, across, cover.points)


def _path(joints: list[Joint], start: int, end: int) -> list[int]:
    """Bodies from `start`, which is left out, to `end`."""
    up, down = _to_base(joints, start), _to_base(joints, end)
    while len(up) > 1 and len(down) > 1 and up[-2] == down[-2]:
        up.pop()
        down.pop()
    return [*up[1:], *reversed(down[:-1])]


def _to_base(joints: list[Joint], body: int) -> list[int]:
    path = [body]
    while path[-1] >= 0:
        path.append(joints[path[-1]].parent)
    return path


def _gap(entry: np.ndarray, axis: np.ndarray | None, points: np.ndarray) -> float:
    """Largest distance of points from a point, or from the line through it along `axis` [m]."""
    offset = points - entry
    return float(np.max(np.linalg.norm(offset if axis is None else np.cross(axis, offset), axis=1)))
