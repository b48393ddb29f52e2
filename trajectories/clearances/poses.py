"""Joint frames, the velocity of points per joint, and the largest distance of bodies from joint axes."""

from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.newton_euler import Joint


class Poses(NamedTuple):
    """Frames that the joints move, in the base frame."""

    rotation: np.ndarray  # rotation of each frame, shape (t, n, 3, 3)
    origin: np.ndarray  # origin of each frame, shape (t, n, 3) [m]
    axis: np.ndarray  # direction of each revolute or prismatic joint axis, shape (t, n, 3)


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
    r"""Derivative of a point's position along a direction by each joint, as if the joint carried the point.

    For a joint about axis a through o this is :math:`d \cdot (a \times (p - o))`
    :math:`= (p \times d) \cdot a - d \cdot (a \times o)`: two matrix products per sample.

    Points and directions are in the base frame, each (t, m, 3). The derivatives have the shape (t, m, n) and
    are in [m/rad], or in [m/m] for a prismatic joint.
    """
    revolute = np.array([joint.revolute for joint in joints])
    along = np.swapaxes(poses.axis, 1, 2)
    moment = np.swapaxes(np.cross(poses.axis, poses.origin), 1, 2)
    turning = np.cross(point, direction) @ along - direction @ moment
    return np.where(revolute, turning, direction @ along)


def moves(joints: list[Joint], body: int) -> np.ndarray:
    """Which joints carry a body, bool of shape (n,); body -1 is the base, body j the link of joint j."""
    carried = np.zeros(len(joints), bool)
    while body >= 0:
        carried[body] = True
        body = joints[body].parent
    return carried


class Cover(NamedTuple):
    """Points whose convex hull contains a body, or the core of a body that is a core with a radius.

    The distance from a ball is that from its center less a constant, so its radius changes no bound.
    """

    body: int  # index of the joint that carries the body, -1 for the base
    points: np.ndarray  # points in that joint's frame, shape (k, 3) [m]


FAR = 1e6
"""Coordinate of a point of an unbounded half-space [m]: the bound of the pair's other body is tighter."""


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

    This is the length of the path from the axis to the body through the joints in between: on each link, from
    the joint at which the path enters to that at which it leaves. So the body moves relative to the axis, as
    seen from the other side of the joint, at no more than this length times the joint's velocity. It is 1 for
    a prismatic joint, whose body is as fast as the joint. `travel` is the largest distance from zero of the
    prismatic joints, shape (n,) [m].
    """
    pivot = joints[joint]
    if not pivot.revolute:
        return 1.0
    down = bool(moves(joints, cover.body)[joint])
    across: np.ndarray | None
    if down:
        current, entry, across = joint, np.zeros(3), pivot.axis
    else:
        current, entry = pivot.parent, pivot.placement.translation
        across = pivot.placement.rotation @ pivot.axis
    length = 0.0
    for step in _path(joints, current, cover.body):
        deeper = step >= 0 and joints[step].parent == current
        crossed = step if deeper else current
        hinge = joints[crossed].placement.translation
        length += _gap(entry, across, (hinge if deeper else np.zeros(3))[None])
        length += 0.0 if joints[crossed].revolute else float(travel[crossed])
        current, entry, across = step, (np.zeros(3) if deeper else hinge), None
    return length + _gap(entry, across, cover.points)


def _path(joints: list[Joint], start: int, end: int) -> list[int]:
    """Bodies on the path from `start`, which is excluded, to `end`."""
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
