"""Errors of a run, each with a value, a limit and what to try; and lines on standard error.

ExidynError
└── RunError: NotAllowed, CannotStart, NotConfirmed
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Timer

from exidyn.identification.errors import ExidynError

from ..screen import beneath


class RunError(ExidynError, RuntimeError):
    """A run cannot begin or continue."""


class NotAllowed(RunError):
    """The arm must not do what was requested."""


class CannotStart(RunError):
    """The motion cannot begin where the arm stands."""


class NotConfirmed(RunError):
    """The user did not confirm the motion."""


CLEAR = "\r\x1b[K"
"""Terminal codes that return to the start of the line and clear it."""
PATIENCE = 2.0
"""Startup time of a simulated arm after which the delay is explained [s]."""
COMPILED = "exidyn: starting the simulated arm; it is compiled the first time, which may take a minute"


def print_line(text: str) -> None:
    """Print to standard error, over the current line of a terminal."""
    if sys.stderr.isatty():
        beneath(sys.stderr).write(CLEAR)
    print(text, file=sys.stderr, flush=True)


@contextmanager
def explained_if_slow() -> Iterator[None]:
    """Explain the delay if a simulated arm starts slowly because it has to be compiled."""
    explanation = Timer(PATIENCE, print_line, [COMPILED])
    explanation.start()
    try:
        yield
    finally:
        explanation.cancel()
