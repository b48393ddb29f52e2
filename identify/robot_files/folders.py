"""Files that a description may name: those in its folder or package, and in folders that the user states.

Otherwise a description from an untrusted source could read any file of this computer: by `..`, by an absolute
path, or by a symbolic link. Links inside a folder that the user states are followed, since `colcon build
--symlink-install` makes such links.
"""

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

from ..errors import BrokenTree, RobotError

VARIABLE = "EXIDYN_FOLDERS"
"""Environment variable with further folders, separated as in PATH."""
PACKAGE = "package.xml"
"""File that makes a folder a package of ROS."""
LAYOUT = ("mjcf", "robots", "urdf", "xacro")
"""Usual names of a package's folder of descriptions. Meshes lie beside it; the two are copied together."""
MJCF_FOLDERS = ("assetdir", "meshdir", "texturedir")
"""Attributes of the element `compiler` of an MJCF that name folders."""
MJCF_MODELS = ("include", "model")
"""Elements whose file is an MJCF, which may name further files."""


@dataclass(frozen=True)
class Folders:
    """Folders whose files a description may name."""

    implied: tuple[Path, ...]  # folders of the description and of its package, with symbolic links resolved
    stated: tuple[Path, ...]  # folders that the user states, as arguments or in the environment

    @classmethod
    def of(cls, description: Path, stated: Iterable[str | Path] = ()) -> "Folders":
        """Folders of a description's file, of its package, of ROS, and those that the user states."""
        file = description.resolve()
        packages = [folder for folder in file.parents if (folder / PACKAGE).is_file()][:1]
        usual = [file.parent.parent] if file.parent.name.lower() in LAYOUT else []
        implied = (description.parent.resolve(), file.parent, *packages, *usual)
        named = [*map(Path, stated), *ros_folders(), *stated_folders()]
        return cls(tuple(dict.fromkeys(implied)), tuple(dict.fromkeys(named)))

    def hold(self, file: Path) -> bool:
        """Whether a file is in one of the folders."""
        real, named = file.resolve(), Path(os.path.abspath(file))
        inside = any(real.is_relative_to(folder) for folder in self.implied)
        return inside or any(
            real.is_relative_to(folder.resolve()) or named.is_relative_to(os.path.abspath(folder))
            for folder in self.stated
        )

    def require(self, file: Path, where: str) -> Path:
        """The file, if it is in one of the folders."""
        if not self.hold(file):
            raise RobotError(f"{where}: {outside(file)}")
        return file


def outside(file: Path) -> str:
    """Message about a file that is in none of the folders."""
    return (
        f"{file.name} is outside of the folder of the description. Put it there, or state its folder in the "
        f"environment variable {VARIABLE}"
    )


def stated_folders() -> list[Path]:
    """Folders that the user states in the environment."""
    return _entries(VARIABLE)


def ros_folders() -> list[Path]:
    """Folders of packages in the environment variables of ROS 1 and ROS 2."""
    return [*_entries("ROS_PACKAGE_PATH"), *(entry / "share" for entry in _entries("AMENT_PREFIX_PATH"))]


def _entries(variable: str) -> list[Path]:
    return [Path(entry) for entry in os.environ.get(variable, "").split(os.pathsep) if entry]


def require_mjcf_files(text: bytes, description: Path) -> dict[str, bytes]:
    """Contents of the files that an MJCF includes, by their names; refuse one that names an outside file.

    Paths in the text are relative to the folder of the file `description`.
    """
    allowed, folder = Folders.of(description), description.parent
    folders, names, included = {""}, list[str](), dict[str, bytes]()
    texts = [(str(description), text)]
    while texts:
        where, content = texts.pop()
        for element in _elements(content, where):
            folders |= {element.attrib[key] for key in MJCF_FOLDERS if key in element.attrib}
            files = [value for key, value in element.attrib.items() if key.startswith("file")]
            names += [*files, *(PurePosixPath(name).name for name in files)]  # strippath removes folders
            for name in files if element.tag in MJCF_MODELS else ():
                for file in (folder / name, Path(where).parent / name):
                    if name not in included and file.is_file():
                        included[name] = allowed.require(file, str(description)).read_bytes()
                        texts.append((str(file), included[name]))
    places = {folder, *((folder / name).parent for name in included)}
    for name in names:
        for file in {place / part / name for place in places for part in folders}:
            if file.exists():
                allowed.require(file, str(description))
    return included


def _elements(text: bytes, where: str) -> Iterator[ElementTree.Element]:
    """All elements of an XML text; raises BrokenTree if it is not XML."""
    try:
        return ElementTree.fromstring(text).iter()
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise BrokenTree(f"{where}: not well-formed XML: {error}") from error
