"""What a command found: as a page for a person, in colour in a terminal, and as JSON for scripts."""

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import datetime
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from exidyn import quoting
from exidyn.identification.text_table import WIDTH
from exidyn.quoting import visible

from ..screen import beneath

HEAD = "written: "
SCREEN = Path("-")
"""In place of a file: standard output."""
BOLD, RED, GREEN, YELLOW = "1", "31", "32", "33"
"""Of a terminal's attributes."""
HEADING = re.compile(r"^.+(?=\n[-=]{20,}$)", re.MULTILINE)
COLOURED = (
    (RED, r"[Mm]ore than noise is left(?: on \w+)?|STOPPED[^:\n]*|BEYOND|WRONG|do not run it|\bwrong$"),
    (RED, r"[^\n]*STILL MOVES[^\n]*|WHETHER THE ARM[^\n]*|PRESS THE[^\n]*"),
    (YELLOW, r"A little is missing|WARNING|(?<=  )warning(?=: )|diverged"),
    (GREEN, r"Nothing is missing|No joint's \w+ differs by more than noise|\bright$|^finished$"),
)
"""Colour and what has it."""
_told = ContextVar("told", default=True)
"""Whether it is printed which files were written."""


def hand_over(page: str, text: str, path: Path | None) -> None:
    """Print the page, or the JSON text where that goes to standard output; write it where it has a file."""
    if path == SCREEN:
        print(text.rstrip("\n"), flush=True)
    else:
        print(coloured(visible(page)), file=beneath(sys.stdout), flush=True)
    if path is not None and path != SCREEN:
        write_whole(path, text)
        print_written(path)


def coloured(page: str, terminal: TextIO | None = None) -> str:
    """The page with colour where standard output, or another stream, is a terminal that shows it.

    `NO_COLOR` in the environment, unless it is empty, and a terminal that is called dumb have none.
    """
    stream = terminal or sys.stdout
    if not stream.isatty() or os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return page
    page = HEADING.sub(_in(BOLD, r"\g<0>"), page)
    for colour, words in COLOURED:
        page = re.sub(words, _in(colour, r"\g<0>"), page, flags=re.MULTILINE)
    return page


def _in(attribute: str, text: str) -> str:
    return f"\x1b[{attribute}m{text}\x1b[0m"


@contextmanager
def files_untold() -> Iterator[None]:
    """Within it nothing is printed of files that were written: who called will call them otherwise."""
    before = _told.set(False)
    try:
        yield
    finally:
        _told.reset(before)


def print_written(*paths: Path, advice: str = "") -> None:
    """Print on standard error which files were written, one a line if a line is too short for all.

    Args:
        paths: Paths of the files.
        advice: What to do with a single one, behind its name.
    """
    if not _told.get():
        return
    together = ", ".join(map(str, paths))
    fits = len(HEAD + together) <= WIDTH
    listed = together if fits else (",\n" + " " * len(HEAD)).join(map(str, paths))
    print(f"{HEAD}{listed}{advice and '; '}{advice}", file=sys.stderr)


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file that appears under its name only when it is whole."""
    part = path.with_name(path.name + ".part")
    part.write_bytes(content if isinstance(content, bytes) else content.encode())
    os.replace(part, path)


def json_text(table: dict[str, Any]) -> str:
    """JSON with a key a line, of values as `plain` takes them."""
    return quoting.json_text(plain(table)) + "\n"


def plain(value: Any) -> Any:
    """Arrays as nested lists; what is no number, which JSON does not have, is None; dates are text."""
    if isinstance(value, dict):
        return {name: plain(one) for name, one in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    if isinstance(value, datetime):
        return value.isoformat()
    return value.item() if isinstance(value, np.generic) else value
