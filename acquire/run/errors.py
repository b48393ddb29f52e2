"""The errors of a run, each a fact with a value, a limit and what to try; and lines on standard error.

ExidynError
└── RunError: NotAllowed, CannotStart, NotConfirmed, RunStopped
    └── RunStopped: Unsafe
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Timer

from exidyn.identification.errors import ExidynError

from ..screen import beneath


class RunError(ExidynError, RuntimeError):
    """A run cannot begin, or not go on."""


class NotAllowed(RunError):
    """What is asked for must not be done with this arm."""


class CannotStart(RunError):
    """The arm does not stand where the motion can begin."""


class NotConfirmed(RunError):
    """Not confirmed."""


class RunStopped(RunError):
    """A run was stopped before its end, and what comes next needs it whole."""


class Unsafe(RunStopped):
    """A run has ended, and the arm still moves, or nobody knows whether it does."""


CLEAR = "\r\x1b[K"
"""Back to the beginning of the line, and away with what stands there."""
PATIENCE = 2.0
"""Time that a simulated arm takes before that is explained [s]."""
COMPILED = "exidyn: the simulated arm starts; the first time it is compiled, which may take a minute"


def print_line(text: str) -> None:
    """Print to standard error, over the line where there is one."""
    if sys.stderr.isatty():
        beneath(sys.stderr).write(CLEAR)
    print(text, file=sys.stderr, flush=True)


@contextmanager
def explained_if_slow() -> Iterator[None]:
    """Prints why a simulated arm takes its time, if it does: the first one is compiled."""
    told = Timer(PATIENCE, print_line, [COMPILED])
    told.start()
    try:
        yield
    finally:
        told.cancel()
