"""Exidyn's own recordings, so that whatever takes a source also takes them."""

from pathlib import Path

from ...model import Model
from ..mcap.mcap_file import read_recording
from ..mcap.mcap_records import MAGIC
from ..recording import Recording

BEGIN = 256
"""Bytes within which our first metadata record begins; only the format's header stands before it."""


def is_own_file(source: Path) -> bool:
    """Whether exidyn wrote an MCAP file, or no known program: then our reader reports what is wrong."""
    with open(source, "rb") as file:
        begin = file.read(BEGIN)
    return not begin.startswith(MAGIC) or b"\x06\x00\x00\x00exidyn" in begin


def import_own_file(source: Path, model: Model | None = None) -> list[Recording]:
    """Read a recording; the robot inside counts, not `model`."""
    return [read_recording(source)]
