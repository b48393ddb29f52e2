"""Files that an MJCF names: those it includes or attaches, meshes, textures and height fields."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

from ..errors import BrokenTree
from .folders import Folders

FOLDERS = ("assetdir", "meshdir", "texturedir")
"""Attributes of the element compiler."""
MODELS = ("include", "model")
"""Elements whose file is an MJCF, which names files in turn."""


@dataclass
class _Found:
    """What was read so far: folders named by compiler elements, names of files, and of files read."""

    folders: set[str] = field(default_factory=lambda: {""})
    names: list[str] = field(default_factory=list)
    included: dict[str, bytes] = field(default_factory=dict)


def require_mjcf_files(text: bytes, description: Path) -> dict[str, bytes]:
    """Refuse an MJCF that names a file outside of its folder; the files that it includes, by their names.

    Args:
        text: Text of the file.
        description: Path of the file; files that it names are looked for from its folder.

    Raises:
        BrokenTree: It is no XML.
        RobotError: With the file, and what to do.
    """
    found, allowed, folder = _Found(), Folders.of(description), description.parent
    texts = [(str(description), text)]
    while texts:
        where, content = texts.pop()
        for name in _read(content, where, found):
            for file in (folder / name, Path(where).parent / name):
                if name not in found.included and file.is_file():
                    allowed.require(file, str(description))
                    found.included[name] = file.read_bytes()
                    texts.append((str(file), found.included[name]))
    places = {folder, *((folder / name).parent for name in found.included)}
    for name in found.names:
        for file in {place / part / name for place in places for part in found.folders}:
            if file.exists():
                allowed.require(file, str(description))
    return found.included


def _read(text: bytes, where: str, found: _Found) -> Iterator[str]:
    """Names of the MJCF that a text includes or attaches; other names go into what was found."""
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise BrokenTree(f"{where}: not well-formed XML: {error}") from error
    for element in root.iter():
        found.folders |= {element.attrib[key] for key in FOLDERS if key in element.attrib}
        names = [value for key, value in element.attrib.items() if key.startswith("file")]
        found.names += [*names, *(PurePosixPath(name).name for name in names)]  # the second by strippath
        if element.tag in MODELS:
            yield from names
