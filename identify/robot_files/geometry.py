"""Collision geometry of a robot: the bodies of its URDF or MJCF, meshes as their convex hulls.

A hull is faster to measure from than a mesh, has a depth of penetration, and holds the whole mesh: a
distance between hulls is never larger than between what they stand for.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import coal
import numpy as np
import pinocchio as pin

from ..errors import BrokenTree, RobotError
from .description import is_description, is_mjcf
from .folders import PACKAGE, Folders, ros_folders
from .hulls import read_hull
from .mjcf_geometry import read_mjcf_geometry
from .robot_file import DESCRIPTIONS, builtin_names
from .toml_fields import parse_toml, read_text, string
from .urdf import parse_urdf, read_choice, read_urdf

SHAPES = ("box", "capsule", "cylinder", "mesh", "sphere")
IN_PACKAGES = ("package://", "model://")
"""Names that start with a package; what follows is the path inside it."""
IN_FILES = ("file://localhost", "file://")


def read_geometry(source: str | Path, package_dirs: Iterable[str | Path] = ()) -> pin.GeometryModel | None:
    """Bodies of the robot that `read_model` reads from the same source, without pairs.

    Each body belongs to a joint and a frame of that robot's kinematics and is called by its link and a
    number, as in Pinocchio.

    Returns:
        None where the robot has no URDF or MJCF, or that no collision geometry.

    Raises:
        RobotError: A mesh is not there or cannot be read, or a shape is wrong; the message names the link.
    """
    description, moving, held = _description_of(source)
    if description is None:
        return None
    if is_mjcf(description):
        return read_mjcf_geometry(description, moving, held)
    return _read_urdf_geometry(description, moving, held, tuple(package_dirs))


def _read_urdf_geometry(
    urdf: Path, moving: list[str] | None, held: dict[str, float], package_dirs: tuple[str | Path, ...]
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


def _description_of(source: str | Path) -> tuple[Path | None, list[str] | None, dict[str, float]]:
    """The URDF or MJCF that a robot is read from, if from one; its joints that move, and that are held."""
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
    rpy, xyz = (_numbers(origin, key, 3, where, "0 0 0") for key in ("rpy", "xyz"))
    return pin.SE3(pin.rpy.rpyToMatrix(rpy), xyz)


def _shape(
    collision: Element,
    urdf: Path,
    package_dirs: Sequence[str | Path],
    meshes: dict[tuple[Path, tuple[float, ...]], coal.Convex],
    where: str,
) -> Any:
    """Shape of a <collision> for coal; a mesh that several links share is read once."""
    geometry = collision.find("geometry")
    kinds = [] if geometry is None else [child for child in geometry if child.tag in SHAPES]
    if len(kinds) != 1:
        raise BrokenTree(f"{where}: expected one of {', '.join(SHAPES)}; found {len(kinds)}")
    element = kinds[0]
    if element.tag != "mesh":
        return _primitive(element, where)
    scale = _numbers(element, "scale", 3, where, "1 1 1")
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
    """Numbers above zero [m]."""
    found = _numbers(element, key, count, where)
    if np.any(found <= 0):
        raise BrokenTree(f'{where}: <{element.tag} {key}="{element.get(key)}">: every size must be above 0 m')
    return found


def _numbers(element: Element, key: str, count: int, where: str, default: str = "") -> np.ndarray:
    text = element.get(key, default)
    try:
        found = np.array([float(word) for word in text.split()])
    except ValueError:
        found = np.empty(0)
    if len(found) != count or not np.all(np.isfinite(found)):
        raise BrokenTree(f'{where}: <{element.tag} {key}="{text}">: expected {count} finite number(s)')
    return found


def _find_mesh(name: str, urdf: Path, package_dirs: Sequence[str | Path], where: str) -> Path:
    """Path of a mesh as a URDF names it: in a package, as a file, or beside the URDF; else an error.

    Such as `package://arm/meshes/link.stl`, `file:///meshes/link.stl` or `meshes/link.stl`. `package_dirs`
    hold packages, or are one, and are searched first.
    """
    for prefix in IN_PACKAGES:
        if name.startswith(prefix):
            package, _, rest = name.removeprefix(prefix).partition("/")
            return _find(name, urdf, package_dirs, _package_roots(urdf, package_dirs), package, rest, where)
    for prefix in IN_FILES:
        name = name.removeprefix(prefix)
    return _find(name, urdf, package_dirs, [urdf.parent, *map(Path, package_dirs)], "", name, where)


def _find(
    name: str,
    urdf: Path,
    stated: Sequence[str | Path],
    folders: list[Path],
    package: str,
    rest: str,
    where: str,
) -> Path:
    allowed = Folders.of(urdf, stated)
    for folder in folders:
        if (folder / package / rest).is_file():
            return _allowed(folder / package / rest, folder / package, package, urdf, allowed, where)
        # a package checked out under another name, or given itself
        if package and _is_package(folder, package) and (folder / rest).is_file():
            return _allowed(folder / rest, folder, package, urdf, allowed, where)
    around = urdf.resolve().parents
    others = [str(folder) for folder in folders if folder.resolve() not in around]
    looked = ", ".join([*others, "the folders around the URDF" if package else "the URDF's own"])
    hint = "set ROS_PACKAGE_PATH" if package else "put it beside the URDF"
    raise RobotError(
        f"{where}: mesh '{name}' is not there. Looked in: {looked}. "
        f"Give the folder that holds it with --packages, or {hint}"
    )


def _allowed(mesh: Path, root: Path, package: str, urdf: Path, folders: Folders, where: str) -> Path:
    """The mesh, if it is in the package that was named, or else where the URDF may have it.

    Raises:
        RobotError: It is elsewhere.
    """
    around = root.resolve() in urdf.resolve().parents and root.name == package
    named = package and (around or (root / PACKAGE).is_file())
    if named and mesh.resolve().is_relative_to(root.resolve()):
        return mesh
    return folders.require(mesh, where)


def _is_package(folder: Path, package: str) -> bool:
    return folder.name == package or (folder / PACKAGE).is_file()


def _package_roots(urdf: Path, package_dirs: Iterable[str | Path]) -> list[Path]:
    """Folders that may hold packages: those given, the URDF's and those around it, ROS 1's and ROS 2's."""
    urdf = urdf.resolve()
    return list(dict.fromkeys([*map(Path, package_dirs), *urdf.parents, *ros_folders()]))
