"""Announcer: prints what a person must know during a run, and reports a blocked loop.

It prints from its own thread, so a slow or stopped (Ctrl-S) terminal does not delay the loop.
"""

import time
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue
from threading import Thread

from .realtime import yield_to_the_loop

BLOCKED = 0.5
"""Time without a cycle after which the loop is reported as blocked [s]: more than twice the watchdog of most
drives (0.2 s), so the drives should have stopped the arm by then."""
LOOK = 0.1
"""Time between checks of the loop [s]."""
FINISH = 1.0
"""Maximum wait for the last texts [s]; a stopped terminal never prints them."""


class Silent:
    """Prints nothing; for runs that nobody watches."""

    def say(self, text: str) -> None:
        """Queue a text for printing; never waits."""

    def begin_cycle(self) -> None:
        """Note that the loop begins a cycle."""

    def stop_watching(self) -> None:
        """Note that the loop has ended."""


class Announcer(Silent):
    """Prints texts in order, and one when the loop is blocked; on exit, it prints the remaining texts."""

    def __init__(self, show: Callable[[str], None], blocked: str) -> None:
        self._show, self._blocked = show, blocked
        self._texts = SimpleQueue[str | None]()
        self._cycle_start: float | None = None
        self._reported = False
        self._thread = Thread(target=self._print, name="announcer", daemon=True)
        self._thread.start()

    def say(self, text: str) -> None:
        self._texts.put(text)

    def begin_cycle(self) -> None:
        self._cycle_start = time.monotonic()

    def stop_watching(self) -> None:
        self._cycle_start = None

    def __enter__(self) -> "Announcer":
        return self

    def __exit__(self, *_: object) -> None:
        self.stop_watching()
        self._texts.put(None)
        self._thread.join(FINISH)

    def _print(self) -> None:
        yield_to_the_loop()
        while True:
            try:
                text = self._texts.get(timeout=LOOK)
            except Empty:
                self._check_loop()
                continue
            if text is None:
                return
            self._print_text(text)

    def _print_text(self, text: str) -> None:
        with suppress(OSError, ValueError):  # the terminal is gone; the run and later texts continue
            self._show(text)

    def _check_loop(self) -> None:
        """Report a blocked loop, once per blockage."""
        start = self._cycle_start
        blocked = start is not None and time.monotonic() - start > BLOCKED
        if blocked and not self._reported:
            self._print_text(self._blocked)
        self._reported = blocked
