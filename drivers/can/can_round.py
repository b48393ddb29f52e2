"""Question and answer on a CAN bus, once a cycle: what every driver's cyclic part does with what it receives.

No thread: nothing here waits. Whatever arrives that is not understood is left alone.
"""

import time
from abc import ABC, abstractmethod

from ..answer_time import AnswerTime
from .can_bus import CanBus
from .transports.transport import STANDARD, Frame

MOST_EVENTS = 50
"""Events that are kept at most for one sample."""
MOST = 500
"""Frames that are read at most before a question is asked: more are a flood, and can wait."""
FORGET = 0.1
"""How long what came unread may be read away [s]."""


class CanRound(ABC):
    """What a question makes the joints answer.

    Args:
        bus: Open.
        names: Of the joints, for messages.

    Attributes:
        fresh: Whether each joint answered the last question.
        fault: The first reason why the arm can no longer be commanded.
        received: Time of the last answer of any joint [s].
    """

    def __init__(self, bus: CanBus, names: list[str]) -> None:
        self._bus, self._names = bus, names
        self.fresh = [False] * len(names)
        self.fault = ""
        self.received = time.monotonic()
        self._waiting = 0
        self._answer_time = AnswerTime()
        self._events: list[str] = []

    @abstractmethod
    def cycle(self, patience: float) -> int:
        """Ask everybody, and wait for the answers.

        Args:
            patience: How long they are waited for [s].

        Returns:
            When they were asked to measure [ns since 1970].
        """

    @abstractmethod
    def _understand(self, identifier: int, data: bytes) -> bool:
        """Take a frame with an 11-bit identifier for what it is; whether it was of a joint."""

    def begin(self) -> None:
        """Forget what came unread, and what was wrong."""
        end = time.monotonic() + FORGET
        while self._bus.receive(0.0) is not None and time.monotonic() < end:
            pass
        self.fault = self._bus.trouble
        self.received = time.monotonic()

    def fail(self, why: str) -> None:
        """The arm can no longer be commanded; the first reason is kept, all are reported."""
        self.fault = self.fault or why
        self.report(why)

    def report(self, text: str) -> None:
        """Keep an event for the next sample."""
        if len(self._events) < MOST_EVENTS:
            self._events.append(text)

    def events(self) -> tuple[str, ...]:
        """What was noticed since the last call."""
        if not self._events:
            return ()
        events, self._events = tuple(self._events), []
        return events

    def _read_late(self) -> None:
        """Read what came after the last wait; late answers do not count for the next question."""
        for _ in range(MOST):
            unreadable, received = self._bus.unreadable, self._bus.receive(0.0)
            if received is not None:
                self._read(received)
            elif self._bus.unreadable == unreadable:
                break
        self.fresh = [False] * len(self._names)
        self._waiting = len(self._names)

    def _collect(self, end: float) -> None:
        """Read until everybody has answered or time is up; what is there already is read in any case."""
        self._answer_time.sleep()
        waited = False
        while self._waiting:
            received = self._bus.receive(0.0)
            if received is None:
                waited, left = True, end - time.monotonic()
                received = self._bus.receive(max(left, 0.0))
                if received is None and (left <= 0.0 or self._bus.trouble):
                    break
            if received is not None:
                self._read(received)
        else:
            self._answer_time.adjust(waited)
        for text in self._bus.events():
            self.report(text)
        if self._bus.trouble and not self.fault:
            self.fail(self._bus.trouble)

    def _answered(self, joint: int) -> None:
        if not self.fresh[joint]:
            self.fresh[joint] = True
            self._waiting -= 1

    def _read(self, received: Frame) -> None:
        identifier, data = received
        if identifier <= STANDARD and self._understand(identifier, data):
            self.received = time.monotonic()
