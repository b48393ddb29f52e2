"""Talk: one question a cycle to all servos of a line, and what to make of silence."""

from collections.abc import Sequence

from ..answer_time import AnswerTime
from ..errors import LinkLost
from .servo_bus import ServoBus
from .servo_packet import Reading, Status

LENGTHS = 4
"""So many questions of different lengths there are."""

LOST = 100
"""After so many exchanges without any answer the link is lost."""


class ServoTalk:
    """The servos' side of the cycles of a run.

    After an answer that was not whole, or bytes that were not asked for, nothing is asked for a cycle, only
    goals are sent. The next question is for another number of bytes, so that an answer to an earlier one,
    however late it comes, cannot be taken for the right one.

    Args:
        bus: Of the servos.
    """

    def __init__(self, bus: ServoBus) -> None:
        self._bus = bus
        self._quiet, self._mute, self._turn = False, 0, 0
        self._answering = [True] * len(bus.servos)
        self._answer_time = AnswerTime()

    def exchange(self, packets: bytes, readings: Sequence[Reading], events: list[str]) -> list[Status | None]:
        """Send packets, ask, and return the answers; None for each servo without one.

        Args:
            packets: These have no answer.
            readings: The question, and the same with more and more bytes in front, `LENGTHS` in all.
            events: What was noticed is added here.

        Raises:
            LinkLost: The port is gone, or there was no answer for a long time.
        """
        answers = self._answers(packets, readings, events)
        self._mute = 0 if any(answer is not None for answer in answers) else self._mute + 1
        if self._mute > LOST:
            raise LinkLost(f"no servo has answered {LOST} times. Look at plugs and power")
        return answers

    def _answers(self, packets: bytes, readings: Sequence[Reading], events: list[str]) -> list[Status | None]:
        unasked = self._bus.drain()
        if unasked and not self._quiet:
            self._turn += 1
            events.append(f"{unasked} bytes came unasked; nothing is asked until the line is silent")
        if unasked or self._quiet:
            self._quiet = bool(unasked)
            self._bus.send_only(packets)
            return [None] * len(self._answering)
        reading, length = readings[self._turn % LENGTHS], readings[0].length
        answers = [
            answer if answer is not None and len(answer.data) == reading.length else None
            for answer in self._bus.ask(reading, packets, self._answer_time)
        ]
        if reading.length > length:
            answers = [answer and answer._replace(data=answer.data[-length:]) for answer in answers]
        self._quiet = not self._bus.in_step
        self._turn += self._quiet
        self._report_changes(answers, events)
        return answers

    def _report_changes(self, answers: Sequence[Status | None], events: list[str]) -> None:
        """Report which fell silent or answers again."""
        answering = [answer is not None for answer in answers]
        if answering == self._answering:
            return
        names = [self._bus.names[servo] for servo in self._bus.servos]
        both = list(zip(names, self._answering, answering, strict=True))
        silent = ", ".join(name for name, before, now in both if before and not now)
        back = ", ".join(name for name, before, now in both if now and not before)
        events += [f"no whole answer from {silent}"] * bool(silent)
        events += [f"answers again from {back}"] * bool(back)
        self._answering = answering
