"""Names of files made from names in files: a robot's or a run's name may hold any text, a path too."""

import re
import unicodedata
from collections.abc import Sequence
from zlib import crc32

LONGEST = 120
"""Bytes of a stem in UTF-8. File systems take 255 of a name; the rest is for a number, an ending, and what
stands around a name while its file is written."""
RESERVED = {"CON", "PRN", "AUX", "NUL", "CONIN", "CONOUT"} | {
    f"{device}{number}" for device in ("COM", "LPT") for number in "0123456789¹²³"
}
"""Names that Windows keeps for devices, whatever ending is behind them."""


def file_stem(name: str, default: str = "unnamed") -> str:
    """A file name without ending, from any text: one component, neither hidden nor reserved nor too long.

    Whatever is no letter, digit, underscore, dot or hyphen becomes an underscore. Different names may have
    the same stem: see `distinct_stems` for those in one folder, `unique_stem` for one at a time.
    The default stands where nothing is left, and before a reserved name.
    """
    composed = unicodedata.normalize("NFC", name)
    # Dots in front would hide a file, or name the folder above; Windows drops those at the end.
    stem = re.sub(r"[^\w.-]+", "_", composed).strip("._-") or default
    if stem.partition(".")[0].upper() in RESERVED:
        stem = f"{default}_{stem}"
    return stem if len(stem.encode()) <= LONGEST else _with_checksum(stem, name)


def unique_stem(name: str, default: str = "unnamed") -> str:
    """As `file_stem`, with a checksum of the name behind it wherever the two differ."""
    stem = file_stem(name, default)
    return stem if stem == name else _with_checksum(stem, name)


def distinct_stems(names: Sequence[str], default: str = "unnamed") -> list[str]:
    """A stem a name, as `file_stem` makes it, numbered where one before is the same: run, run_1.

    Upper and lower case count as the same, as they do on the disks of Windows and macOS.
    """
    stems: list[str] = []
    taken: set[str] = set()
    for name in names:
        stem = free = file_stem(name, default)
        number = 0
        while free.casefold() in taken:
            number += 1
            free = f"{stem}_{number}"
        taken.add(free.casefold())
        stems.append(free)
    return stems


def _with_checksum(stem: str, name: str) -> str:
    """The stem, shortened to fit, and a checksum of the whole name."""
    checksum = f"-{crc32(name.encode('utf-8', 'surrogatepass')):08x}"
    kept = stem.encode()[: LONGEST - len(checksum)].decode(errors="ignore").rstrip("._-")
    return kept + checksum
