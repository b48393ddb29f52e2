"""Terminal streams that print control characters as their codes.

Otherwise a name in a file could move the cursor, hide what was printed, or change the terminal's title.
"""

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

from exidyn.quoting import visible


class Screen:
    """A stream that prints control characters as their codes and otherwise behaves like the one beneath."""

    def __init__(self, beneath: TextIO) -> None:
        self.beneath = beneath  # the wrapped stream

    def write(self, text: str) -> int:
        """Write a text."""
        self.beneath.write(visible(text))
        return len(text)

    def writelines(self, texts: Iterable[str]) -> None:
        """Write several texts."""
        for text in texts:
            self.write(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.beneath, name)


def beneath(stream: TextIO) -> TextIO:
    """The wrapped stream, for colors and cursor movements of exidyn; texts go through `visible` first."""
    return stream.beneath if isinstance(stream, Screen) else stream


@contextmanager
def screens() -> Iterator[None]:
    """Replace standard output and standard error by screens within the context."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = map(_screen, before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def _screen(stream: TextIO | None) -> Any:
    """The stream as a screen; a stream that was closed before the start stays None."""
    return stream if stream is None or isinstance(stream, Screen) else cast(TextIO, Screen(stream))
