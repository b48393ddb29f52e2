"""Collision geometry of a robot: the bodies of its URDF or MJCF, with convex hulls in place of meshes.

Distances between hulls are faster to compute than between meshes, and include a depth of penetration. A hull
contains its mesh, so the distance between two hulls never exceeds the distance between the meshes. Of an
MJCF, geoms that can collide are the bodies.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import coal
import numpy as np
import pinocchio as pin
from scipy.spatial import ConvexHull, QhullError

from ..arm.robot import Held
from ..errors import BrokenTree, RobotError
from .description import is_description, is_mjcf
from .folders import PACKAGE, VARIABLE, Folders, ros_folders, stated_folders
from .mjcf import body_parts, compile_mjcf, mjcf_kinematics
from .mjcf_elements import enum_of, name_of
from .mjcf_held import placement_of
from .robot_file import DESCRIPTIONS, builtin_names
from .toml_fields import parse_toml, read_text, string
from .urdf import parse_urdf, read_choice, read_urdf
from .urdf_checks import attribute_numbers

SHAPES = ("box", "capsule", "cylinder", "mesh", "sphere")
IN_PACKAGES = ("package://", "model://")
"""Prefixes of names that consist of a package and the path inside it."""
IN_FILES = ("file://localhost", "file://")


def read_geometry(source: str | Path, package_dirs: Iterable[str | Path] = ()) -> pin.GeometryModel | None:
    """Collision bodies of the robot that `read_model` reads from the same source, without pairs.

    Each body belongs to a joint and a frame of that robot's kinematics. Its name is its link and a number, as
    in Pinocchio. None if the robot has no URDF or MJCF, or if that has no collision geometry.
    """
    description, moving, held = _description_of(source)
    if description is None:
        return None
    if is_mjcf(description):
        return _read_mjcf_geometry(description, moving, held)
    return _read_urdf_geometry(description, moving, held, tuple(package_dirs))


def _read_urdf_geometry(
    urdf: Path, moving: list[str] | None, held: Held, package_dirs: tuple[str | Path, ...]
) -> pin.GeometryModel | None:
    text = read_urdf(urdf)
    kinematics = parse_urdf(text, str(urdf), moving, held).model
    geometry = pin.GeometryModel()
    meshes: dict[tuple[Path, tuple[float, ...]], coal.Convex] = {}
    for link in ElementTree.fromstring(text).findall("link"):
        name = link.get("name", "")
        frame = kinematics.frames[kinematics.getFrameId(name, pin.FrameType.BODY)]
        for count, collision in enumerate(link.findall("collision")):
            where = f"{urdf}: collision geometry of link '{name}'"
            shape = _shape(collision, urdf, package_dirs, meshes, where)
            placement = frame.placement * _placement(collision, where)
            index = kinematics.getFrameId(name, pin.FrameType.BODY)
            body = pin.GeometryObject(f"{name}_{count}", frame.parentJoint, index, placement, shape)
            geometry.addGeometryObject(body)
    return geometry if geometry.ngeoms else None


def _description_of(source: str | Path) -> tuple[Path | None, list[str] | None, Held]:
    """URDF or MJCF of a robot, None if it has none; its moving joints, and its held joints."""
    path = Path(source)
    if str(source) in builtin_names():
        return None, None, {}
    if is_description(path):
        return path, None, {}
    table = parse_toml(read_text(path), "robot file")
    named = next((key for key in DESCRIPTIONS if key in table), None)
    description = path.parent / string(table[named], named) if named else None
    return description, *read_choice(table, str(path))


def _placement(collision: Element, where: str) -> pin.SE3:
    origin = collision.find("origin")
    if origin is None:
        return pin.SE3.Identity()
    rpy, xyz = (attribute_numbers(origin, key, 3, where, "0 0 0") for key in ("rpy", "xyz"))
    return pin.SE3(pin.rpy.rpyToMatrix(rpy), xyz)


def _shape(
    collision: Element,
    urdf: Path,
    package_dirs: Sequence[str | Path],
    meshes: dict[tuple[Path, tuple[float, ...]], coal.Convex],
    where: str,
) -> Any:
    """Shape of a <collision> element for coal; a mesh that several links share is read once."""
    geometry = collision.find("geometry")
    kinds = [] if geometry is None else [child for child in geometry if child.tag in SHAPES]
    if len(kinds) != 1:
        raise BrokenTree(f"{where}: expected one of {', '.join(SHAPES)}; found {len(kinds)}")
    element = kinds[0]
    if element.tag != "mesh":
        return _primitive(element, where)
    scale = attribute_numbers(element, "scale", 3, where, "1 1 1")
    path = _find_mesh(element.get("filename", ""), urdf, package_dirs, where)
    key = (path, tuple(scale))
    if key not in meshes:
        meshes[key] = read_hull(path, scale, where)
    return meshes[key]


def _primitive(element: Element, where: str) -> Any:
    if element.tag == "box":
        return coal.Box(*_sizes(element, "size", 3, where))
    radius = _sizes(element, "radius", 1, where)[0]
    if element.tag == "sphere":
        return coal.Sphere(radius)
    length = _sizes(element, "length", 1, where)[0]
    return coal.Capsule(radius, length) if element.tag == "capsule" else coal.Cylinder(radius, length)


def _sizes(element: Element, key: str, count: int, where: str) -> np.ndarray:
    """Sizes of a shape, which are above zero [m]."""
    sizes = attribute_numbers(element, key, count, where)
    if np.any(sizes <= 0):
        raise BrokenTree(f'{where}: <{element.tag} {key}="{element.get(key)}">: every size must be above 0 m')
    return sizes


def _find_mesh(name: str, urdf: Path, package_dirs: Sequence[str | Path], where: str) -> Path:
    """Path of a mesh that a URDF names: in a package, as a file, or beside the URDF.

    Examples of names are `package://arm/meshes/link.stl`, `file:///meshes/link.stl` and `meshes/link.stl`.
    `package_dirs` are packages or folders of packages. They are searched first, then `EXIDYN_FOLDERS`.
    """
    for prefix in IN_FILES:
        name = name.removeprefix(prefix)
    scheme = next((prefix for prefix in IN_PACKAGES if name.startswith(prefix)), "")
    package, _, inside = name.removeprefix(scheme).partition("/") if scheme else ("", "", name)
    stated, parents = [*map(Path, package_dirs), *stated_folders()], urdf.resolve().parents
    folders = [*stated, *parents, *ros_folders()] if scheme else [urdf.parent, *stated]
    for folder in dict.fromkeys(folders):
        roots = [folder / package]
        if package and (folder.name == package or (folder / PACKAGE).is_file()):
            roots.append(folder)  # a package that was checked out under another name, or stated itself
        for root in roots:
            if (root / inside).is_file():
                mesh, around = root / inside, root.resolve() in parents and root.name == package
                stated_package = package and (around or (root / PACKAGE).is_file())
                if stated_package and mesh.resolve().is_relative_to(root.resolve()):
                    return mesh  # the URDF may name files of a package
                return Folders.of(urdf, package_dirs).require(mesh, where)
    others = [str(folder) for folder in dict.fromkeys(folders) if folder.resolve() not in parents]
    searched = ", ".join([*others, "the folders around the URDF" if package else "the folder of the URDF"])
    hint = "ROS_PACKAGE_PATH" if package else "put it beside the URDF"
    raise RobotError(
        f"{where}: mesh '{name}' is missing. Searched: {searched}. State its folder in the environment "
        f"variable {VARIABLE}, or {hint}"
    )


ROUND = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
"""Angles of the points that stand for an ellipsoid, since coal has no distance from one to a half-space."""


def _read_mjcf_geometry(path: Path, moving: Sequence[str] | None, held: Held) -> pin.GeometryModel | None:
    """Collision bodies of the robot that `mjcf_kinematics` makes with the same arguments, without pairs.

    The name of each is that of its body and a number. Everything that is fixed to the base, including floors
    and tables, belongs to the base.

    Returns:
        None if no geom can collide.
    """
    model = compile_mjcf(path)
    tree = mjcf_kinematics(model, str(path), moving, held).model
    parts = body_parts(model, moving, held, str(path))
    kinds = {enum_of("mjtGeom", f"mjGEOM_{name.upper()}"): make for name, make in GEOMS.items()}
    frames = {frame.parentJoint: i for i, frame in enumerate(tree.frames) if frame.type == pin.FrameType.BODY}
    geometry, counts = pin.GeometryModel(), [0] * model.nbody
    for geom in np.flatnonzero(model.geom_contype | model.geom_conaffinity).tolist():
        make, body = kinds.get(int(model.geom_type[geom])), int(model.geom_bodyid[geom])
        if make is None:  # height fields are not convex
            continue
        part, name = parts[body], f"{name_of(model, 'body', body)}_{counts[body]}"
        placement = part.placement * placement_of(model.geom_pos[geom], model.geom_quat[geom])
        shape = make(model, geom, model.geom_size[geom])
        frame = frames.get(part.joint, 0)
        geometry.addGeometryObject(pin.GeometryObject(name, part.joint, frame, placement, shape))
        counts[body] += 1
    return geometry if geometry.ngeoms else None


def _mesh(model: Any, geom: int, _: np.ndarray) -> coal.Convex:
    mesh = model.geom_dataid[geom]
    start = model.mesh_vertadr[mesh]
    return hull(np.array(model.mesh_vert[start : start + model.mesh_vertnum[mesh]], float))


def _ellipsoid(_: Any, __: int, size: np.ndarray) -> coal.Convex:
    """Convex hull that contains the ellipsoid, and so is a little larger."""
    along, up = np.meshgrid(ROUND, ROUND[: len(ROUND) // 2 + 1])
    points = np.stack([np.cos(along) * np.sin(up), np.sin(along) * np.sin(up), np.cos(up)], axis=-1)
    return hull(points.reshape(-1, 3) * size / np.cos(np.pi / len(ROUND)) ** 2)


GEOMS = {
    "plane": lambda *_: coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0),
    "sphere": lambda _, __, size: coal.Sphere(size[0]),
    "capsule": lambda _, __, size: coal.Capsule(size[0], 2 * size[1]),
    "ellipsoid": _ellipsoid,
    "cylinder": lambda _, __, size: coal.Cylinder(size[0], 2 * size[1]),
    "box": lambda _, __, size: coal.Box(*(2 * size)),
    "mesh": _mesh,
}
"""Kind of a geom -> function that makes its shape from the model, the geom's index and its sizes."""


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
