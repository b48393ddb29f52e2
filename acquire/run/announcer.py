"""Announcer: prints what a person must know during a run, as it happens, and reports a blocked loop.

It prints from its own thread, so a slow terminal, or one that was stopped (Ctrl-S), does not delay the loop.
"""

import time
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue
from threading import Thread

from .realtime import yield_to_the_loop

BLOCKED = 0.5
"""Time without a cycle after which a person is told [s]: more than twice the watchdog of most drives (0.2 s),
so that the arm should have stopped by itself."""
LOOK = 0.1
"""Time between looks at the loop [s]."""
FINISH = 1.0
"""Longest wait for the last texts [s]; a stopped terminal never prints them."""


class Silent:
    """Prints nothing: for runs without a person."""

    def say(self, text: str) -> None:
        """Queue a text for printing; never waits."""

    def come_round(self) -> None:
        """Note that the loop begins a cycle."""

    def leave(self) -> None:
        """Note that the loop has ended; it is no longer watched."""


class Announcer(Silent):
    """Prints texts in order; a context manager that prints the remaining texts at its end.

    Args:
        show: Prints a text.
        blocked: Text to print when the loop is blocked.
    """

    def __init__(self, show: Callable[[str], None], blocked: str) -> None:
        self._show, self._blocked = show, blocked
        self._texts = SimpleQueue[str | None]()
        self._round: float | None = None
        self._told = False
        self._thread = Thread(target=self._print, name="announcer", daemon=True)
        self._thread.start()

    def say(self, text: str) -> None:
        self._texts.put(text)

    def come_round(self) -> None:
        self._round = time.monotonic()

    def leave(self) -> None:
        self._round = None

    def __enter__(self) -> "Announcer":
        return self

    def __exit__(self, *_: object) -> None:
        self.leave()
        self._texts.put(None)
        self._thread.join(FINISH)

    def _print(self) -> None:
        yield_to_the_loop()
        while True:
            try:
                text = self._texts.get(timeout=LOOK)
            except Empty:
                self._look()
                continue
            if text is None:
                return
            self._print_text(text)

    def _print_text(self, text: str) -> None:
        with suppress(OSError, ValueError):  # a terminal that is gone; the run goes on, and so do later texts
            self._show(text)

    def _look(self) -> None:
        """Report a blocked loop, once each time."""
        begun = self._round
        blocked = begun is not None and time.monotonic() - begun > BLOCKED
        if blocked and not self._told:
            self._print_text(self._blocked)
        self._told = blocked
