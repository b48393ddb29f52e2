"""Names of files, made from any text, even a path; files that are written whole or are missing."""

import os
import re
import unicodedata
from collections.abc import Sequence
from pathlib import Path
from zlib import crc32

LONGEST = 120
"""Maximum length of a stem in bytes of UTF-8. File systems allow 255 for a name; the difference is for a
number, an ending, and the prefix and suffix of a file that is being written."""
RESERVED = {"CON", "PRN", "AUX", "NUL", "CONIN", "CONOUT"} | {
    f"{device}{number}" for device in ("COM", "LPT") for number in "0123456789¹²³"
}
"""Names that Windows reserves for devices, with any ending."""


def file_stem(name: str, default: str = "unnamed") -> str:
    """File name without ending from any text: one path component, not hidden, not reserved, not too long.

    Every other character than a letter, digit, underscore, dot or hyphen becomes an underscore. Different
    names may have the same stem: use `distinct_stems` for the names in one folder. The default replaces an
    empty stem, and precedes a reserved name.
    """
    composed = unicodedata.normalize("NFC", name)
    # A leading dot would hide the file or name the folder above; Windows drops dots at the end.
    stem = re.sub(r"[^\w.-]+", "_", composed).strip("._-") or default
    if stem.partition(".")[0].upper() in RESERVED:
        stem = f"{default}_{stem}"
    return stem if len(stem.encode()) <= LONGEST else _with_checksum(stem, name)


def distinct_stems(names: Sequence[str], default: str = "unnamed") -> list[str]:
    """One stem per name, made by `file_stem`; repeated stems are numbered: run, run_1.

    Case is ignored, as in the file systems of Windows and macOS.
    """
    stems: list[str] = []
    used: set[str] = set()
    for name in names:
        stem = free = file_stem(name, default)
        number = 0
        while free.casefold() in used:
            number += 1
            free = f"{stem}_{number}"
        used.add(free.casefold())
        stems.append(free)
    return stems


def looked_in(path: str | os.PathLike[str]) -> str:
    """The folder in which a missing file was looked for, as the end of an error message."""
    try:
        folder = os.path.dirname(os.path.abspath(path))
    except OSError:  # the current folder was removed
        return ""
    return f"; looked in {folder}" if os.path.isdir(folder) else f"; there is no folder {folder}"


def write_whole(path: Path | str, content: str | bytes) -> Path:
    """Write a file that appears under its name only once it is complete; returns its path."""
    part = Path(path).with_name(Path(path).name + ".part")
    part.write_bytes(content if isinstance(content, bytes) else content.encode())
    return part.replace(path)


def other_format(number: object, valid: int, command: str) -> str:
    """Words for a file of another format than the valid one; the command writes an older file anew."""
    newer = isinstance(number, int) and number > valid
    advice = "update exidyn" if newer else f"write it anew with exidyn {command}"
    return f"format {number!r}; this version reads {valid}; {advice}"


def read_failure(path: str | os.PathLike[str], error: OSError) -> str:
    """Why a file cannot be read; for a missing file, with the folder in which it was looked for."""
    reason = error.strerror or str(error)
    return f"{reason}{looked_in(path)}" if isinstance(error, FileNotFoundError) else reason


def _with_checksum(stem: str, name: str) -> str:
    """Stem, shortened to fit, followed by a checksum of the name."""
    checksum = f"-{crc32(name.encode('utf-8', 'surrogatepass')):08x}"
    shortened = stem.encode()[: LONGEST - len(checksum)].decode(errors="ignore").rstrip("._-")
    return shortened + checksum
