"""Redraw: lines in a terminal that are drawn again in place."""

import shutil
from collections.abc import Sequence
from typing import TextIO


class Redraw:
    """Draws lines over those that it drew before.

    Args:
        terminal: Where to.
    """

    def __init__(self, terminal: TextIO) -> None:
        self._terminal, self._drawn = terminal, 0

    def draw(self, lines: Sequence[str]) -> None:
        """Draw these in place of the last; what does not fit into the terminal is cut off."""
        size = shutil.get_terminal_size()
        # A line that wraps, or scrolls away, could not be drawn over.
        shown = [line[: size.columns - 1] for line in lines[: size.lines - 1]]
        back = f"\x1b[{self._drawn}A" if self._drawn else ""
        self._terminal.write(back + "\x1b[J" + "".join(f"{line}\n" for line in shown))
        self._terminal.flush()
        self._drawn = len(shown)
