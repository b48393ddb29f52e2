"""Results of a command: a page for a person, in color in a terminal, and JSON for scripts."""

import os
import re
import sys
from pathlib import Path
from typing import Any, TextIO

import exidyn.quoting as quoting
from exidyn.identification.file_names import write_whole
from exidyn.identification.result_file import to_table
from exidyn.identification.text_table import page_width, paragraph
from exidyn.quoting import visible

from ..screen import beneath

HEAD = "written: "
SCREEN = Path("-")
"""Path that stands for standard output."""
BOLD, RED, GREEN, YELLOW = "1", "31", "32", "33"
"""ANSI codes of text attributes."""
HEADING = re.compile(r"^.+(?=\n[-=]{20,}$)", re.MULTILINE)
COLORED = (
    (RED, r"[Mm]ore than noise is left(?: on \w+)?|STOPPED[^:\n]*|BEYOND|WRONG|do not run it|\bwrong$"),
    (RED, r"[^\n]*STILL MOVES[^\n]*|WHETHER THE ARM[^\n]*|PRESS THE[^\n]*"),
    (YELLOW, r"A little is missing|WARNING|(?<=  )warning(?=: )|diverged"),
    (GREEN, r"Nothing is missing|No joint's \w+ differs by more than noise|\bright$|^finished$"),
)
"""Color and the pattern of the words that have it."""


def hand_over(page: str, text: str, path: Path | None) -> None:
    """Print the page and write the JSON text to its file, or print the JSON alone for standard output."""
    if path == SCREEN:
        print(text.rstrip("\n"), flush=True)
    else:
        print(colored(visible(page)), file=beneath(sys.stdout), flush=True)
    if path is not None and path != SCREEN:
        write_whole(path, text)
        print_written(path)


def colored(page: str, terminal: TextIO | None = None) -> str:
    """The page in color if standard output, or another stream, is a terminal that shows color.

    A non-empty `NO_COLOR` in the environment and the terminal type `dumb` turn color off.
    """
    stream = terminal or sys.stdout
    if not stream.isatty() or os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return page
    page = HEADING.sub(_in(BOLD, r"\g<0>"), page)
    for color, words in COLORED:
        page = re.sub(words, _in(color, r"\g<0>"), page, flags=re.MULTILINE)
    return page


def _in(attribute: str, text: str) -> str:
    return f"\x1b[{attribute}m{text}\x1b[0m"


def print_written(*paths: Path) -> None:
    """Print the names of written files on standard error; if they are too long, the folder once."""
    listed, [folder, *others] = ", ".join(map(str, paths)), dict.fromkeys(path.parent for path in paths)
    if len(paths) > 1 and not others and len(HEAD + listed) > page_width.get():
        listed = f"in {folder}: {', '.join(path.name for path in paths)}"
    print("\n".join(paragraph(listed, " " * len(HEAD), HEAD)), file=sys.stderr)


def print_next(*commands: str) -> None:
    """Print the commands that usually follow on standard error, each ready to be pasted."""
    for command in commands:
        print(f"next: exidyn {command}", file=sys.stderr)


def json_text(table: dict[str, Any]) -> str:
    """JSON text with one key per line, of values that `to_table` accepts."""
    return quoting.json_text(to_table(table)) + "\n"
