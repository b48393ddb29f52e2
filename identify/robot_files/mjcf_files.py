"""Files that an MJCF names: included or attached models, meshes, textures and height fields."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

from ..errors import BrokenTree
from .folders import Folders

FOLDERS = ("assetdir", "meshdir", "texturedir")
"""Attributes of the element `compiler` that name folders."""
MODELS = ("include", "model")
"""Elements whose file is an MJCF, which may name further files."""


@dataclass
class _NamedFiles:
    """Folders named by compiler elements, names of files, and contents of included files by their names."""

    folders: set[str] = field(default_factory=lambda: {""})
    names: list[str] = field(default_factory=list)
    included: dict[str, bytes] = field(default_factory=dict)


def require_mjcf_files(text: bytes, description: Path) -> dict[str, bytes]:
    """Refuse an MJCF that names a file outside of its folder.

    Args:
        text: Text of the file.
        description: Path of the file; paths in it are relative to its folder.

    Returns:
        Contents of the files that it includes, by their names.

    Raises:
        BrokenTree: The text is not XML.
        RobotError: A file is outside; the message names it and says what to do.
    """
    named, allowed, folder = _NamedFiles(), Folders.of(description), description.parent
    texts = [(str(description), text)]
    while texts:
        where, content = texts.pop()
        for name in _read(content, where, named):
            for file in (folder / name, Path(where).parent / name):
                if name not in named.included and file.is_file():
                    allowed.require(file, str(description))
                    named.included[name] = file.read_bytes()
                    texts.append((str(file), named.included[name]))
    places = {folder, *((folder / name).parent for name in named.included)}
    for name in named.names:
        for file in {place / part / name for place in places for part in named.folders}:
            if file.exists():
                allowed.require(file, str(description))
    return named.included


def _read(text: bytes, where: str, named: _NamedFiles) -> Iterator[str]:
    """Names of the MJCF files that a text includes or attaches; all names are added to `named`."""
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise BrokenTree(f"{where}: not well-formed XML: {error}") from error
    for element in root.iter():
        named.folders |= {element.attrib[key] for key in FOLDERS if key in element.attrib}
        names = [value for key, value in element.attrib.items() if key.startswith("file")]
        named.names += [*names, *(PurePosixPath(name).name for name in names)]  # strippath removes folders
        if element.tag in MODELS:
            yield from names
