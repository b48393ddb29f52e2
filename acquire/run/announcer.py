"""Announcer: prints at once what a person must know while a run goes on, and says when its loop is blocked.

It prints from a thread of its own: a terminal that is slow, or that was stopped (Ctrl-S), does not hold up
the loop.
"""

import time
from collections.abc import Callable
from queue import Empty, SimpleQueue
from threading import Thread

from .realtime import yield_to_the_loop

BLOCKED = 0.5
"""Time without a cycle after which a person is told [s]: twice what the drives of most arms bear, and what a
person takes to react to it."""
LOOK = 0.1
"""Time between looks at the loop [s]."""
FINISH = 1.0
"""Time that the last texts may take [s]; a terminal that was stopped is not waited for longer."""


class Silent:
    """Says nothing: for runs without a person."""

    def say(self, text: str) -> None:
        """Print a text soon; never waits."""

    def come_round(self) -> None:
        """The loop begins a cycle."""

    def leave(self) -> None:
        """The loop has ended, and is no longer watched."""


class Announcer(Silent):
    """Prints texts in their order; a context manager that prints the last ones.

    Args:
        show: Prints a text.
        blocked: What to print where the loop is blocked.
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
            self._show(text)

    def _look(self) -> None:
        """Tell a person, once for each time, that the loop does not come round."""
        begun = self._round
        blocked = begun is not None and time.monotonic() - begun > BLOCKED
        if blocked and not self._told:
            self._show(self._blocked)
        self._told = blocked
