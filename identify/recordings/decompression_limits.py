"""Limits on the size of decompressed files, so that a small file cannot fill the memory."""

import gzip
import os
from pathlib import Path
from zipfile import ZipFile

from ..errors import NotAFile, RecordingError

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


def require_gzip(path: Path) -> None:
    """Refuse a gzip file that decompresses to more bytes than the limit; reads it to its end."""
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
