"""How far from a joint's axis a body can get, whatever the other joints do."""

from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from exidyn.identify.arm.newton_euler import Joint

from .poses import moves


class Cover(NamedTuple):
    """Points whose convex hull holds a body, or its core where it is that and a radius all around.

    A distance from a ball is that from its centre less a constant, so its radius changes no bound.

    Attributes:
        body: The joint that carries it, -1 for the base.
        points: In that joint's frame, shape (k, 3) [m].
    """

    body: int
    points: np.ndarray


def cover(body: pin.GeometryObject) -> Cover:
    """Cover of a body of the collision geometry."""
    shape = body.geometry
    kind = type(shape).__name__
    if kind.startswith("Convex"):
        points = np.array(shape.points(), float).reshape(-1, 3)
    elif kind in ("Sphere", "Capsule"):
        half = shape.halfLength if kind == "Capsule" else 0.0
        points = np.array([[0.0, 0.0, -half], [0.0, 0.0, half]])
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
