"""What a person asks for while the arm moves: Ctrl-C brakes, a second one stops quickly, SIGTERM brakes."""

import signal
from types import FrameType
from typing import Any

from exidyn.drivers import StopLevel

from .stop import Stop


class StopRequests:
    """A context manager that turns signals into reasons to stop. For the main thread.

    A recorder and a view have process groups of their own, so Ctrl-C does not reach them.
    """

    def __init__(self) -> None:
        self.stop: Stop | None = None
        self._before: dict[int, Any] = {}

    def __enter__(self) -> "StopRequests":
        for number in (signal.SIGINT, signal.SIGTERM):
            self._before[number] = signal.signal(number, self._ask)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _ask(self, number: int, frame: FrameType | None) -> None:
        again = self.stop is not None and number == signal.SIGINT
        name = signal.Signals(number).name
        level = StopLevel.QUICK if again else StopLevel.BRAKE
        words = "Ctrl-C again: quick stop" if again else f"asked to stop ({name})"
        if self.stop is None or level > self.stop.level:
            self.stop = Stop(level, "asked", words)
