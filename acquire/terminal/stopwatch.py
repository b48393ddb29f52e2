"""How far a command that takes its time has got."""

import sys
import time
from collections.abc import Callable

Progress = Callable[[str], None]
"""Called with a sentence at each stage."""


def stopwatch() -> Progress:
    """Prints sentences on standard error with the seconds since it was made."""
    start = time.perf_counter()

    def progress(sentence: str) -> None:
        print(f"{time.perf_counter() - start:6.1f} s  {sentence}", file=sys.stderr, flush=True)

    return progress
