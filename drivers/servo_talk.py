"""Talk: one question a cycle to all servos of a line, and what to make of silence."""

from collections.abc import Sequence

import numpy as np

from .errors import LinkLost
from .servo_bus import ServoBus
from .servo_packet import Reading, Status

LENGTHS = 4
"""So many questions of different lengths there are."""

LOST = 0.25
"""After so long without any answer the link is lost [s]."""


class ServoTalk:
    """The servos' side of the cycles of a run.

    After an answer that was not whole, or bytes that nobody asked for, nothing is asked for a cycle, only
    goals are sent. The next question is for another number of bytes, so that an answer to an earlier one,
    however late it comes, cannot be taken for the right one.

    Args:
        bus: Of the servos.
        cycle: Time between questions [s].
    """

    def __init__(self, bus: ServoBus, cycle: float) -> None:
        self._bus, self._cycle = bus, cycle
        self._quiet, self._mute, self._turn = False, 0, 0
        self._answering = np.ones(len(bus.servos), bool)

    def exchange(
        self, packets: bytes, readings: Sequence[Reading], cycles: int, events: list[str]
    ) -> list[Status | None]:
        """Send packets, ask, and return the answers; None for each servo without one.

        Args:
            packets: Nobody answers these.
            readings: The question, and the same with more and more bytes behind, `LENGTHS` in all.
            cycles: That have passed since the last one.
            events: What was noticed is added here.

        Raises:
            LinkLost: The port is gone, or nobody has answered for a long time.
        """
        answers = self._answers(packets, readings, events)
        self._mute = 0 if any(answer is not None for answer in answers) else self._mute + cycles
        if self._mute * self._cycle > LOST:
            raise LinkLost(f"no servo has answered for {LOST:g} s. Look at plugs and power")
        return answers

    def _answers(self, packets: bytes, readings: Sequence[Reading], events: list[str]) -> list[Status | None]:
        unasked = self._bus.drain()
        if unasked and not self._quiet:
            self._turn += 1
            events.append(f"{unasked} bytes came unasked; nothing is asked until the line is silent")
        if unasked or self._quiet:
            self._quiet = bool(unasked)
            self._bus.tell(packets)
            return [None] * len(self._answering)
        reading, length = readings[self._turn % LENGTHS], readings[0].length
        answers = [
            answer._replace(data=answer.data[:length])
            if answer is not None and len(answer.data) == reading.length
            else None
            for answer in self._bus.ask(reading, packets)
        ]
        self._quiet = not self._bus.in_step
        self._turn += self._quiet
        self._tell_changes(answers, events)
        return answers

    def _tell_changes(self, answers: Sequence[Status | None], events: list[str]) -> None:
        """Say who fell silent or speaks again."""
        answering = np.array([answer is not None for answer in answers])
        for news, text in (
            (self._answering & ~answering, "no whole answer from"),
            (answering & ~self._answering, "answers again from"),
        ):
            if news.any():
                who = [self._bus.names[self._bus.servos[place]] for place in np.flatnonzero(news)]
                events.append(f"{text} {', '.join(who)}")
        self._answering = answering
