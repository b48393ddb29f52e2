"""Read a file by a library in native code in a process apart, which a damaged file may kill or fill."""

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from ...errors import NotAFile
from ...limited_process import Ended, call
from ..decompression_limits import largest_size, too_large
from .tables.table import Table

START = 60.0
"""How long libraries may take to be imported, on a busy machine with a cold disk [s]; usually 0.3 s."""
SLOWEST = 1e6
"""Bytes of the file that are read in a second at least: less than a hundredth of what decompression takes."""
LIBRARIES = 300_000_000
"""Memory of Python with its libraries before they read anything [B]."""
HELD = 3
"""How many times the content of a file is held: as it was read, as columns, and as one table."""


def read_apart(place: str, library: str, source: Path) -> list[Table]:
    """The tables that a reader finds in a file.

    Args:
        place: "module:function" in this package; the function takes a path.
        library: What errors call the reader.
        source: File or folder.

    Raises:
        NotAFile: The reader died, took too long, needs too much memory, or refused the file.
        RecordingError: The file is no table; whatever else the reader raises on purpose, too.
        MissingPackage: The library is not installed.
        OSError: The file cannot be opened.
    """
    rows = call_reader(f"{__name__}:read_rows", library, source, place)
    return [Table(**row | {"joints": tuple(row["joints"])}) for row in rows]


def read_rows(source: str, place: str) -> list[dict[str, Any]]:
    """The fields of the tables in a file, in the process apart; such readers give no lines of a text file."""
    module, name = place.split(":")
    tables: Sequence[Table] = getattr(import_module(f"{__package__}.{module}"), name)(Path(source))
    return [{key: value for key, value in table._asdict().items() if key != "lines"} for table in tables]


def call_reader(place: str, library: str, source: Path, *arguments: Any) -> Any:
    """What a function makes of a file in a process apart, within the limits for a file of its size.

    Args:
        place: "module:function" with the module's whole name.
        library: What errors call the reader.
        source: File or folder, the function's first argument.
        arguments: The function's other arguments, which JSON can hold.

    Raises:
        NotAFile: The reader died, took too long, or needs too much memory.
        ExidynError: The function raised it; type and text are kept.
        OSError: The file cannot be opened.
    """
    files = source.rglob("*") if source.is_dir() else [source]
    seconds = START + sum(path.stat().st_size for path in files if path.is_file()) / SLOWEST
    try:
        return call(place, [str(source), *arguments], LIBRARIES + HELD * largest_size(source), seconds)
    except Ended as error:
        raise NotAFile(
            f"{source}: {library}, which reads it, {error}: the file is damaged. Write it anew, or as CSV"
        ) from None
    except MemoryError:
        raise too_large(source) from None
