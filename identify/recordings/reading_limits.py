"""Limits on reading the files of others: a small file cannot fill the memory when it is decompressed.

Native libraries, which a damaged file may crash or fill, run in a separate process.
"""

import gzip
import os
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from ..errors import NotAFile, RecordingError
from ..limited_process import Ended, call

VARIABLE = "EXIDYN_LARGEST_FILE"
"""Environment variable with another limit [B], for files from a trusted source."""
LEAST = 200_000_000
"""Limit for small files [B]: 25 million numbers, such as an hour of position and current of six joints at
500 Hz."""
RATIO = 20
"""Limit for larger files, over their size: measured numbers compress to a third or a fifth, nearly constant
numbers to a tenth, and a decompression bomb to a thousandth."""
PIECE = 1 << 20
"""Size of a piece of decompressed data while the size is counted [B]."""
START = 60.0
"""Maximum time to import libraries, on a busy machine with a cold disk [s]; usually 0.3 s."""
SLOWEST = 1e6
"""Minimum reading rate [B/s]: less than a hundredth of the rate of decompression."""
LIBRARIES = 300_000_000
"""Memory of Python and its libraries before they read a file [B]."""
HELD = 3
"""Number of copies of a file's content in memory: as read, as columns, and as one table."""


def largest_size(path: Path) -> int:
    """Largest size of the content of a file or folder [B]."""
    stated = os.environ.get(VARIABLE, "")
    if stated:
        if not stated.isdecimal():
            raise RecordingError(f"{VARIABLE} is '{stated}'; expected a number of bytes such as {10 * LEAST}")
        return int(stated)
    files = path.rglob("*") if path.is_dir() else [path]
    size = sum(file.stat().st_size for file in files if file.is_file())
    return max(LEAST, RATIO * size)


def too_large(path: Path) -> NotAFile:
    """Error for a file whose content exceeds the limit."""
    return NotAFile(
        f"{path}: its content exceeds {largest_size(path) / 1e6:.0f} MB, the limit for its size. If "
        f"its source is trusted, state a larger limit in bytes: {VARIABLE}={5 * largest_size(path)}"
    )


def require_size(path: Path, size: int) -> None:
    """Refuse a file whose content has more bytes than the limit."""
    if size > largest_size(path):
        raise too_large(path)


def opened(path: Path, mode: str, **options: Any) -> Any:
    """An open file, decompressed if its name ends in .gz."""
    return (gzip.open if path.name.endswith(".gz") else open)(path, mode, **options)


def require_gzip(path: Path) -> None:
    """Refuse a file .gz that decompresses to more bytes than the limit; reads it to its end."""
    if not path.name.endswith(".gz"):
        return
    limit, size = largest_size(path), 0
    with gzip.open(path) as stream:
        while piece := stream.read(PIECE):
            size += len(piece)
            if size > limit:
                raise too_large(path)


def require_zip(path: Path) -> None:
    """Refuse a zip archive, such as an .npz, whose members state more bytes than the limit.

    Members are never read beyond their stated size.
    """
    with ZipFile(path) as archive:
        require_size(path, sum(member.file_size for member in archive.infolist()))


def call_reader(place: str, library: str, source: Path, *arguments: Any) -> Any:
    """Result of a function that reads a file in a separate process, with limits for the size of the file.

    `place` is "module:function" with the full name of the module; JSON can represent its `arguments`, which
    follow the path. `library` is the name of the reader in messages. Raises `NotAFile` if the reader crashes,
    takes too long, or needs too much memory, and what the function raises.
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
