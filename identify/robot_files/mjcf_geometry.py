"""Collision geometry of an MJCF: geoms that can collide, with convex hulls in place of meshes."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from ..arm.robot import Held
from .hulls import hull
from .mjcf import Part, body_parts, compile_mjcf, mjcf_kinematics
from .mjcf_held import placement_of
from .mjcf_names import enum_of, name_of

ROUND = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
"""Angles of the points that stand for an ellipsoid, since coal has no distance from one to a half-space."""


def read_mjcf_geometry(path: Path, moving: Sequence[str] | None, held: Held) -> pin.GeometryModel | None:
    """Collision bodies of the robot that `mjcf_kinematics` makes with the same arguments, without pairs.

    The name of each is that of its body and a number. Everything that is fixed to the base, including floors
    and tables, belongs to the base.

    Returns:
        None if no geom can collide.
    """
    model = compile_mjcf(path)
    tree = mjcf_kinematics(model, str(path), moving, held).model
    parts = body_parts(model, moving, held, str(path))
    geometry, counts = pin.GeometryModel(), [0] * model.nbody
    for geom in np.flatnonzero(model.geom_contype | model.geom_conaffinity):
        shape, body = _shape(model, int(geom)), int(model.geom_bodyid[geom])
        if shape is not None:
            name = f"{name_of(model, 'body', body)}_{counts[body]}"
            geometry.addGeometryObject(_body(model, int(geom), parts[body], tree, name, shape))
            counts[body] += 1
    return geometry if geometry.ngeoms else None


def _body(model: Any, geom: int, part: Part, tree: pin.Model, name: str, shape: Any) -> pin.GeometryObject:
    """Collision body of a geom, on the joint that carries it."""
    frames = [
        index
        for index, frame in enumerate(tree.frames)
        if frame.parentJoint == part.joint and frame.type == pin.FrameType.BODY
    ]
    placement = part.placement * placement_of(model.geom_pos[geom], model.geom_quat[geom])
    return pin.GeometryObject(name, part.joint, frames[-1] if frames else 0, placement, shape)


def _shape(model: Any, geom: int) -> Any:
    """Shape for coal; None for height fields, which are not convex."""
    size, kind = model.geom_size[geom], int(model.geom_type[geom])
    kinds = {name: enum_of("mjtGeom", f"mjGEOM_{name.upper()}") for name in SHAPES}
    name = next((name for name, value in kinds.items() if value == kind), "")
    return SHAPES[name](model, geom, size) if name else None


def _mesh(model: Any, geom: int, _: np.ndarray) -> coal.Convex:
    mesh = model.geom_dataid[geom]
    start = model.mesh_vertadr[mesh]
    return hull(np.array(model.mesh_vert[start : start + model.mesh_vertnum[mesh]], float))


def _ellipsoid(_: Any, __: int, size: np.ndarray) -> coal.Convex:
    """Convex hull that contains the ellipsoid, and so is a little larger."""
    along, up = np.meshgrid(ROUND, ROUND[: len(ROUND) // 2 + 1])
    points = np.stack([np.cos(along) * np.sin(up), np.sin(along) * np.sin(up), np.cos(up)], axis=-1)
    return hull(points.reshape(-1, 3) * size / np.cos(np.pi / len(ROUND)) ** 2)


SHAPES = {
    "plane": lambda *_: coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0),
    "sphere": lambda _, __, size: coal.Sphere(size[0]),
    "capsule": lambda _, __, size: coal.Capsule(size[0], 2 * size[1]),
    "ellipsoid": _ellipsoid,
    "cylinder": lambda _, __, size: coal.Cylinder(size[0], 2 * size[1]),
    "box": lambda _, __, size: coal.Box(*(2 * size)),
    "mesh": _mesh,
}
"""Kind of a geom -> function that makes its shape from the model, the geom's index and its sizes."""
