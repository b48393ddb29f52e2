"""Recordings from other people's files: one file a format, one line in this table."""

import inspect
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from ...errors import NotAFile, UnknownKey
from ...model import Model
from ..recording import Recording

IMPORTERS: dict[str, str] = {
    "case_folder": "case_folder:import_case_folder",
    "csv": "csv_file:import_csv",
    "exidyn": "own_file:import_own_file",
    "kuka_trace": "kuka_trace:import_kuka_trace",
    "ros2_bag": "ros2_bag:import_ros2_bag",
}
"""Name -> "module:function", imported when asked for; each takes (source, model, **options)."""


def import_source(
    source: Path | str, model: Model | None = None, kind: str | None = None, **options: Any
) -> list[Recording]:
    """Import whatever a path is.

    Args:
        source: File or folder.
        model: The nominal robot; case folders and exidyn's own files bring theirs.
        kind: Key of `IMPORTERS`; found from what lies at the path by default.
        options: Passed to the importer; its docstring lists them.

    Raises:
        NotAFile: There is nothing at that path, or no importer reads what is there.
        UnknownKey: An option or a kind that does not exist; the message lists the valid ones.
    """
    source = Path(source)
    if not source.exists():
        raise NotAFile(f"{source} does not exist")
    kind = kind or kind_of(source)
    if kind not in IMPORTERS:
        raise UnknownKey(kind, "import: kind of source", tuple(IMPORTERS))
    module, name = IMPORTERS[kind].split(":")
    function: Callable[..., list[Recording]] = getattr(import_module(f"{__name__}.{module}"), name)
    valid = tuple(inspect.signature(function).parameters)[2:]
    for option in options:
        if option not in valid:
            raise UnknownKey(option, f"import of {kind}", valid)
    return function(source, model, **options)


def kind_of(source: Path) -> str:
    """Which importer reads what lies at a path.

    Raises:
        NotAFile: None does; the message names what lies one level below and can be imported.
    """
    kind = _kind(source)
    if kind is None and source.name.endswith(".mcap.part"):
        raise NotAFile(
            f"{source} was left unfinished by a recorder that crashed or still writes. Make a whole "
            f"recording of it: exidyn recover {source}"
        )
    if kind is None:
        raise NotAFile(
            f"{source} is nothing that can be imported{_below(source)}. Known are: CSV (.csv, .csv.gz), a "
            "case folder with case.toml, KUKA traces (.dat with .r64), ROS 2 bags (folder, .db3, .mcap) and "
            "exidyn's own .mcap"
        )
    return kind


def _below(source: Path) -> str:
    """The folders in a folder that can be imported, in words."""
    if not source.is_dir():
        return ""
    folders = sorted(path.name for path in source.iterdir() if path.is_dir() and _kind(path))
    return f", but these folders in it can, one at a time: {', '.join(folders)}" if folders else ""


def _kind(source: Path) -> str | None:
    name = source.name.lower()
    if source.is_dir():
        if (source / "case.toml").exists():
            return "case_folder"
        if (source / "metadata.yaml").exists():
            return "ros2_bag"
        if any(file.suffix.lower() == ".dat" for file in source.iterdir()):
            return "kuka_trace"
    elif name == "case.toml":
        return "case_folder"
    elif name.endswith((".csv", ".csv.gz", ".tsv", ".txt", ".txt.gz")):
        return "csv"
    elif name.endswith((".dat", ".r64")):
        return "kuka_trace"
    elif name.endswith(".db3"):
        return "ros2_bag"
    elif name.endswith(".mcap"):
        from .own_file import is_own_file

        return "exidyn" if is_own_file(source) else "ros2_bag"
    return None
