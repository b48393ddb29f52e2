"""Collision geometry of a robot: the bodies of its URDF or MJCF, with convex hulls in place of meshes.

Distances between hulls are faster to compute than between meshes, and include a depth of penetration. A hull
contains its mesh, so the distance between two hulls never exceeds the distance between the meshes.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import coal
import numpy as np
import pinocchio as pin

from ..arm.robot import Held
from ..errors import BrokenTree, RobotError
from .description import is_description, is_mjcf
from .folders import PACKAGE, VARIABLE, Folders, ros_folders, stated_folders
from .hulls import read_hull
from .mjcf_geometry import read_mjcf_geometry
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
        return read_mjcf_geometry(description, moving, held)
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
    stated, around = [*map(Path, package_dirs), *stated_folders()], urdf.resolve().parents
    folders = [*stated, *around, *ros_folders()] if scheme else [urdf.parent, *stated]
    for folder in dict.fromkeys(folders):
        roots = [folder / package]
        if package and (folder.name == package or (folder / PACKAGE).is_file()):
            roots.append(folder)  # a package that was checked out under another name, or stated itself
        for root in roots:
            if (root / inside).is_file():
                return _allowed(root / inside, root, package, urdf, Folders.of(urdf, package_dirs), where)
    others = [str(folder) for folder in dict.fromkeys(folders) if folder.resolve() not in around]
    searched = ", ".join([*others, "the folders around the URDF" if package else "the folder of the URDF"])
    hint = "ROS_PACKAGE_PATH" if package else "put it beside the URDF"
    raise RobotError(
        f"{where}: mesh '{name}' is missing. Searched: {searched}. State its folder in the environment "
        f"variable {VARIABLE}, or {hint}"
    )


def _allowed(mesh: Path, root: Path, package: str, urdf: Path, folders: Folders, where: str) -> Path:
    """The mesh, if it is in the named package or in a folder whose files the URDF may name."""
    around = root.resolve() in urdf.resolve().parents and root.name == package
    named = package and (around or (root / PACKAGE).is_file())
    if named and mesh.resolve().is_relative_to(root.resolve()):
        return mesh
    return folders.require(mesh, where)
