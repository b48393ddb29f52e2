"""Lines on standard error, over the line of progress where there is one."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Timer

CLEAR = "\r\x1b[K"
"""Back to the beginning of the line, and away with what stands there."""
PATIENCE = 2.0
"""Time that a simulated arm takes before that is explained [s]."""
COMPILED = "exidyn: the simulated arm starts; the first time it is compiled, which may take a minute"


def print_line(text: str) -> None:
    """Print to standard error, over the line where there is one."""
    print(f"{CLEAR if sys.stderr.isatty() else ''}{text}", file=sys.stderr, flush=True)


@contextmanager
def explained_if_slow() -> Iterator[None]:
    """Prints why a simulated arm takes its time, if it does: the first one is compiled."""
    told = Timer(PATIENCE, print_line, [COMPILED])
    told.start()
    try:
        yield
    finally:
        told.cancel()
