"""Convex hulls of points and of mesh files."""

from pathlib import Path

import coal
import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ..errors import RobotError


def read_hull(path: Path, scale: np.ndarray, where: str) -> coal.Convex:
    """Convex hull of a mesh file, with its points scaled along x, y and z."""
    try:
        mesh = coal.MeshLoader().load(str(path), scale)
        return hull(np.array(mesh.vertices(), float).reshape(-1, 3))
    except (RuntimeError, ValueError, IndexError) as error:
        first = (str(error).strip() or "no reason given").splitlines()[0]
        raise RobotError(f"{where}: mesh {path} cannot be read: {first}") from error


def hull(points: np.ndarray) -> coal.Convex:
    """Convex hull of points, shape (k, 3) [m]."""
    if len(points) < 4:
        raise ValueError(f"{len(points)} points; a body has at least 4")
    try:
        convex = ConvexHull(points)
    except QhullError:
        convex = ConvexHull(points, qhull_options="QJ")  # a flat mesh; joggling its points gives it a volume
    place = np.full(len(points), -1)
    place[convex.vertices] = np.arange(len(convex.vertices))
    corners = points[convex.vertices]
    triangles = place[convex.simplices]
    first, second, third = np.moveaxis(corners[triangles], 1, 0)
    inward = np.sum(np.cross(second - first, third - first) * convex.equations[:, :3], axis=1) < 0
    triangles[inward] = triangles[inward][:, ::-1]  # coal expects counter-clockwise order, seen from outside
    vertices, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    vertices.extend(list(corners))
    faces.extend([coal.Triangle(*map(int, row)) for row in triangles])
    return coal.Convex(vertices, faces)
