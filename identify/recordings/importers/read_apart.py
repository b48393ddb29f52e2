"""Read files with native libraries in a separate process, which a damaged file may crash or fill."""

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from ...errors import NotAFile
from ...limited_process import Ended, call
from ..decompression_limits import largest_size, too_large
from ..tables.table import Table

START = 60.0
"""Maximum time to import libraries, on a busy machine with a cold disk [s]; usually 0.3 s."""
SLOWEST = 1e6
"""Minimum reading rate [B/s]: less than a hundredth of the rate of decompression."""
LIBRARIES = 300_000_000
"""Memory of Python and its libraries before they read a file [B]."""
HELD = 3
"""Number of copies of a file's content in memory: as read, as columns, and as one table."""


def read_apart(place: str, library: str, source: Path) -> list[Table]:
    """Tables in a file, read in a separate process by the function "module:function" of this package.

    `library` is the name of the reader in messages.
    """
    rows = call_reader(f"{__name__}:read_rows", library, source, place)
    return [Table(**row | {"joints": tuple(row["joints"])}) for row in rows]


def read_rows(source: str, place: str) -> list[dict[str, Any]]:
    """Fields of the tables in a file, without lines of text; this runs in the separate process."""
    module, name = place.split(":")
    tables: Sequence[Table] = getattr(import_module(f"{__package__}.{module}"), name)(Path(source))
    return [{key: value for key, value in table._asdict().items() if key != "lines"} for table in tables]


def call_reader(place: str, library: str, source: Path, *arguments: Any) -> Any:
    """Result of a function that reads a file in a separate process, with limits for the size of the file.

    Args:
        place: "module:function" with the full name of the module.
        library: Name of the reader in messages.
        source: Path of the file or folder, the first argument of the function.
        arguments: Other arguments of the function, which JSON can represent.

    Raises:
        NotAFile: The reader crashed, took too long, or needs too much memory.
        ExidynError: The function raised it; type and text are preserved.
        OSError: The file cannot be opened.
    """
    files = source.rglob("*") if source.is_dir() else [source]
    seconds = START + sum(path.stat().st_size for path in files if path.is_file()) / SLOWEST
    try:
        return call(place, [str(source), *arguments], LIBRARIES + HELD * largest_size(source), seconds)
    except Ended as error:
        raise NotAFile(
            f"{source}: its reader, {library}, {error}: the file is damaged. Write it again, or as CSV"
        ) from None
    except MemoryError:
        raise too_large(source) from None
