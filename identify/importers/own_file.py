"""Exidyn's own recordings, so that whatever takes a source also takes them."""

from pathlib import Path

from ..mcap_file import read_recording
from ..mcap_records import read_contents
from ..model import Model
from ..recording import Recording


def is_own_file(source: Path) -> bool:
    """Whether an MCAP file says that exidyn wrote it."""
    return "exidyn" in read_contents(source).metadata


def import_own_file(source: Path, model: Model | None = None) -> list[Recording]:
    """Read a recording; the robot inside counts, not `model`."""
    return [read_recording(source)]
