"""Colour on a page of text: headings, and what is right or wrong with an arm."""

import os
import re
import sys
from typing import TextIO

BOLD, RED, GREEN, YELLOW = "1", "31", "32", "33"
"""Of a terminal's attributes."""
HEADING = re.compile(r"^.+(?=\n[-=]{20,}$)", re.MULTILINE)
WORDS = (
    (RED, r"[Pp]hysics is missing(?: on \w+)?|STOPPED[^:\n]*|BEYOND|WRONG|do not run it|\bwrong$"),
    (RED, r"[^\n]*STILL MOVES[^\n]*|WHETHER THE ARM[^\n]*|PRESS THE[^\n]*"),
    (YELLOW, r"A little is missing|WARNING|(?<=  )warning(?=: )|diverged"),
    (GREEN, r"Nothing is missing|No joint's \w+ differs by more than noise|\bright$|^finished$"),
)
"""Colour -> what has it."""


def coloured(page: str, terminal: TextIO | None = None) -> str:
    """The page with colour where standard output, or another stream, shows it; else as it is.

    `NO_COLOR` in the environment, unless it is empty, and a terminal that is called dumb have none.
    """
    if not shows_colour(terminal or sys.stdout):
        return page
    page = HEADING.sub(_in(BOLD, r"\g<0>"), page)
    for colour, words in WORDS:
        page = re.sub(words, _in(colour, r"\g<0>"), page, flags=re.MULTILINE)
    return page


def shows_colour(terminal: TextIO) -> bool:
    """Whether a stream is a terminal with colour that a person wants."""
    return terminal.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def _in(attribute: str, text: str) -> str:
    return f"\x1b[{attribute}m{text}\x1b[0m"
