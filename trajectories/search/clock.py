"""Clocks that measure how much of its budget a start has used, in seconds or in iterations."""

import time


class Clock:
    """Time since a start began [s].

    Attributes:
        offer: Initial guess of the cost of bringing a series inside all limits, in the clock's unit.
    """

    offer = 0.3

    def __init__(self) -> None:
        self._begun = time.monotonic()

    def now(self) -> float:
        """Budget used so far."""
        return time.monotonic() - self._begun

    def iterate(self) -> None:
        """Count an iteration."""

    def deliver(self) -> None:
        """Count a series brought inside all limits."""


class IterationClock(Clock):
    """Iterations since a start began: a slow computer then does the same work as a fast computer."""

    offer = 10.0

    def __init__(self) -> None:
        self._count = 0.0

    def now(self) -> float:
        return self._count

    def iterate(self) -> None:
        self._count += 1.0

    def deliver(self) -> None:
        self._count += self.offer
