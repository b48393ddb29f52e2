"""Where the meshes that a URDF names lie on this disk."""

import os
from collections.abc import Iterable
from pathlib import Path

from ..errors import RobotError

IN_PACKAGES = ("package://", "model://")
"""Names that start with a package; what follows is the path inside it."""
IN_FILES = ("file://localhost", "file://")


def find_mesh(name: str, urdf: Path, package_dirs: Iterable[str | Path], where: str) -> Path:
    """Path of a mesh as a URDF names it: in a package, as a file, or beside the URDF.

    Args:
        name: `package://arm/meshes/link.stl`, `file:///meshes/link.stl` or `meshes/link.stl`.
        urdf: Path of the URDF.
        package_dirs: Folders that hold packages, or are one; searched first.
        where: Who asks, for the error.

    Raises:
        RobotError: It is in none of the folders, which the message lists; those around the URDF in a word.
    """
    for prefix in IN_PACKAGES:
        if name.startswith(prefix):
            package, _, rest = name.removeprefix(prefix).partition("/")
            return _find(name, urdf, _package_roots(urdf, package_dirs), package, rest, where)
    for prefix in IN_FILES:
        name = name.removeprefix(prefix)
    return _find(name, urdf, [urdf.parent, *map(Path, package_dirs)], "", name, where)


def _find(name: str, urdf: Path, folders: list[Path], package: str, rest: str, where: str) -> Path:
    for folder in folders:
        if (folder / package / rest).is_file():
            return folder / package / rest
        # a package checked out under another name, or given itself
        if package and _is_package(folder, package) and (folder / rest).is_file():
            return folder / rest
    around = urdf.resolve().parents
    others = [str(folder) for folder in folders if folder.resolve() not in around]
    looked = ", ".join([*others, "the folders around the URDF" if package else "the URDF's own"])
    hint = "set ROS_PACKAGE_PATH" if package else "put it beside the URDF"
    raise RobotError(
        f"{where}: mesh '{name}' is not there. Looked in: {looked}. "
        f"Give the folder that holds it with --packages, or {hint}"
    )


def _is_package(folder: Path, package: str) -> bool:
    return folder.name == package or (folder / "package.xml").is_file()


def _package_roots(urdf: Path, package_dirs: Iterable[str | Path]) -> list[Path]:
    """Folders that may hold packages: those given, the URDF's and those around it, ROS 1's and ROS 2's."""
    urdf = urdf.resolve()
    ros = [Path(entry) for entry in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if entry]
    ament = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    shares = [Path(entry) / "share" for entry in ament if entry]
    return list(dict.fromkeys([*map(Path, package_dirs), *urdf.parents, *ros, *shares]))
