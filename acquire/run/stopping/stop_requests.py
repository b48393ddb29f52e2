"""What a person asks for while the arm moves: Ctrl-C brakes, a second one stops quickly, SIGTERM brakes.

So does a terminal that goes away.
"""

import signal
from types import FrameType
from typing import Any

from exidyn.drivers import StopLevel

from .stop import Stop

BRAKING = ("SIGINT", "SIGTERM", "SIGHUP")
"""What is taken for a request, where the operating system has it."""


class StopRequests:
    """A context manager that turns signals into reasons to stop. For the main thread.

    Until the request is read, nothing moves, and a driver may be waiting for a person: then the first
    request interrupts, as Ctrl-C usually does. A recorder and a view have process groups of their own, so
    Ctrl-C does not reach them.
    """

    def __init__(self) -> None:
        self.stop: Stop | None = None
        self._looked = False
        self._before: dict[int, Any] = {}

    def __enter__(self) -> "StopRequests":
        for number in (getattr(signal, name) for name in BRAKING if hasattr(signal, name)):
            if number == getattr(signal, "SIGHUP", None) and signal.getsignal(number) == signal.SIG_IGN:
                continue  # nohup: the run is to outlive the terminal
            self._before[number] = signal.signal(number, self._ask)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def look(self) -> Stop | None:
        """What is asked for; from the first look on nothing is interrupted."""
        self._looked = True
        return self.stop

    def _ask(self, number: int, frame: FrameType | None) -> None:
        again = self.stop is not None and number == signal.SIGINT
        name = signal.Signals(number).name
        level = StopLevel.QUICK if again else StopLevel.BRAKE
        words = "Ctrl-C again: quick stop" if again else f"asked to stop ({name})"
        if self.stop is None or level > self.stop.level:
            self.stop = Stop(level, "asked", words)
        if not self._looked:
            self._looked = True  # what is done on the way out must not be interrupted too
            raise KeyboardInterrupt
