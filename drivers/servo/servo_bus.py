"""Servos on a serial line: ask them, command them, and never take an old answer for a new one.

Answers carry no number. One that comes after its deadline would be read in the next cycle, look right and be
late from then on. So a question looks first whether something is waiting already, and afterwards whether
there is more than was asked for; in warning the line is left alone until it is silent.
"""

import time
from collections.abc import Mapping, Sequence

from ..errors import LinkLost, NotReady
from ..host_clock import AnswerTime
from .serial_port import SerialPort
from .servo_line import Codec, Parsed, Reading, Register, Status

TRIES = 3
"""How often a question or a setting is repeated before the run."""


class ServoBus:
    """The servos of an arm on an open port; names by id, in the order of the joints.

    Attributes:
        in_step: Whether the last answer was whole, in order, and nothing came behind it.
    """

    def __init__(self, port: SerialPort, codec: Codec, names: Mapping[int, str]) -> None:
        self._port, self._codec, self.names = port, codec, dict(names)
        self.servos = tuple(self.names)
        self.in_step = True

    def send_only(self, packets: bytes) -> None:
        """Send what has no answer. Raises LinkLost if the port is gone."""
        if packets:
            self._port.write(packets)

    def drain(self) -> int:
        """Throw away what came unasked; its number of bytes. Raises LinkLost if the port is gone."""
        return self._port.drain()

    def ask(
        self, reading: Reading, before: bytes = b"", answer_time: AnswerTime | None = None
    ) -> list[Status | None]:
        """The answers in the order of the question; None for each that did not come or is not valid.

        Packets can be sent before the question, in the same write. `answer_time` is how long its answers
        usually take, None for a rare one. Raises LinkLost if the port is gone.
        """
        self._port.write(before + reading.packet)
        if answer_time is not None:
            answer_time.sleep()
        count, size = len(reading.servos), reading.answer_bytes
        data = self._port.read(size)
        if answer_time is not None and len(data) == size:
            answer_time.adjust(self._port.waited)
        found = reading.parse(data)
        while size <= len(data) < 2 * size and len(found.statuses) + found.broken < count:
            more = self._port.read(1)  # stuffing makes answers longer than can be known before
            if not more:
                break
            data += more
            found = reading.parse(data)
        servos = tuple(status.servo for status in found.statuses)
        if servos == reading.servos:
            self.in_step = not self._port.waiting
            return list(found.statuses) if self.in_step else [None] * count
        return self._sorted(reading, found, len(data) >= size)

    def _sorted(self, reading: Reading, found: Parsed, long_enough: bool) -> list[Status | None]:
        """Answers that are not those of all servos in their order, as `ask` gives them."""
        count = len(reading.servos)
        places = [
            reading.servos.index(s.servo) if s.servo in reading.servos else count for s in found.statuses
        ]
        in_order = all(a < b for a, b in zip(places, [*places[1:], count], strict=False))
        orderly = in_order and not self._port.waiting
        self.in_step = orderly and long_enough and len(found.statuses) + found.broken >= count
        answers: list[Status | None] = [None] * count
        if orderly:
            for place, status in zip(places, found.statuses, strict=True):
                answers[place] = status
        return answers

    def ping(self, servo: int) -> bytes | None:
        """Data of a servo; None if it does not answer. Raises LinkLost if the port is gone."""
        for _ in range(TRIES):
            self.drain()
            question = self._codec.ping(servo)
            answer = self.ask(question)[0]
            if answer is not None and len(answer.data) == question.length:
                return answer.data
        return None

    def find(self, baudrate: int, baudrates: Sequence[int]) -> list[bytes]:
        """Data of all servos, which can have these baudrates, at the one of the port [bit/s].

        Raises LinkLost if some do not answer, NotReady if the adapter answers for them.
        """
        self._require_no_echo()
        answers = {servo: self.ping(servo) for servo in self.servos}
        found = [data for data in answers.values() if data is not None]
        if len(found) == len(answers):
            return found
        silent = ", ".join(self.names[servo] for servo, data in answers.items() if data is None)
        there = ", ".join(str(servo) for servo, data in answers.items() if data is not None) or "none"
        others = ", ".join(str(rate) for rate in baudrates if rate != baudrate)
        raise LinkLost(
            f"{silent} did not answer at {baudrate} bit/s; {there} did. Look at plugs, power and ids, or try "
            f"another baudrate: {others}"
        )

    def _require_no_echo(self) -> None:
        """Raise where the adapter echoes: a ping can look like the answer of a servo with an alarm."""
        question = self._codec.sync_read(0, 1, self.servos)
        self.drain()
        self.send_only(question.packet)
        if self._port.read(len(question.packet) + question.answer_bytes).startswith(question.packet):
            raise NotReady(
                "the adapter sends back what it is sent, so that answers look like questions. Try "
                "one that listens only while it does not send, as those of the servos' makers do"
            )

    def read(self, register: Register) -> list[int]:
        """A register of all servos. Raises LinkLost if some do not answer, or refuse."""
        for _ in range(TRIES):
            answers = self._answers(register)
            found = [_number(answer, register) for answer in answers]
            whole = [one for one in found if one is not None]
            if len(whole) == len(self.servos):
                return whole
        texts = [
            f"{self.names[servo]} is silent" if answer is None else self.refusal(answer)
            for servo, answer, one in zip(self.servos, answers, found, strict=True)
            if one is None
        ]
        raise LinkLost(f"{register} cannot be read: {', '.join(texts)}. Look at plugs and power")

    def refusal(self, answer: Status) -> str:
        """Which servo refuses a question, and why; empty where the answer has valid data."""
        meaning = self._codec.refusal(answer.error)
        return f"{self.names[answer.servo]} answers with {meaning}" if meaning else ""

    def require(self, register: Register, value: int, advice: str) -> None:
        """Raise NotReady where a servo has another value; LinkLost if some do not answer."""
        for servo, found in zip(self.servos, self.read(register), strict=True):
            if found != value:
                raise NotReady(f"{self.names[servo]} is in {register.name} {found}, not {value} {advice}")

    def peek(self, register: Register) -> list[int | None]:
        """A register of all servos, asked for once; None if silent. Raises LinkLost if the port is gone."""
        return [_number(answer, register) for answer in self._answers(register)]

    def _answers(self, register: Register) -> list[Status | None]:
        self.drain()
        return self.ask(self._codec.sync_read(register.address, register.size, self.servos))

    def packet(self, register: Register, values: Sequence[int]) -> bytes:
        """What sets a register of all servos."""
        size = register.size
        mask = (1 << 8 * size) - 1
        blocks = {
            servo: (value & mask).to_bytes(size, "little")
            for servo, value in zip(self.servos, values, strict=True)
        }
        return self._codec.sync_write(register.address, blocks)

    def settle(self, register: Register, values: Sequence[int], pause: float = 0.0) -> None:
        """Set a register of all servos and read it back, after a pause for memory that takes its time [s].

        Raises LinkLost if some do not answer, NotReady if some do not take it.
        """
        wrong: list[str] = []
        for _ in range(TRIES):
            self.send_only(self.packet(register, values))
            time.sleep(pause)
            wrong = [
                f"{self.names[servo]} has {found} instead of {value}"
                for servo, value, found in zip(self.servos, values, self.read(register), strict=True)
                if found != value
            ]
            if not wrong:
                return
        raise NotReady(f"{register} is not taken: {', '.join(wrong)}")


def _number(answer: Status | None, register: Register) -> int | None:
    """What a register holds by an answer; None for one without."""
    if answer is None or len(answer.data) != register.size:
        return None
    return int.from_bytes(answer.data, "little", signed=register.signed)


LENGTHS = 4
"""So many questions of different lengths there are."""

LOST = 100
"""After so many exchanges without any answer the link is lost."""


class ServoTalk:
    """The servos' side of the cycles of a run.

    After an answer that was not whole, or bytes that were not asked for, nothing is asked for a cycle, only
    goals are sent. The next question is for another number of bytes, so that an answer to an earlier one,
    however late it comes, cannot be taken for the right one.
    """

    def __init__(self, bus: ServoBus) -> None:
        self._bus = bus
        self._quiet, self._mute, self._turn = False, 0, 0
        self._answering = [True] * len(bus.servos)
        self._errors = [0] * len(bus.servos)
        self._answer_time = AnswerTime()

    def exchange(self, packets: bytes, readings: Sequence[Reading], events: list[str]) -> list[Status | None]:
        """Send packets, ask, and return the answers; None for each servo without one.

        `readings` are the question, and the same with more and more bytes in front, `LENGTHS` in all. What
        was noticed is added to `events`. Raises LinkLost if the port is gone, or after no answer for a long
        time.
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
        statuses = self._bus.ask(reading, packets, self._answer_time)
        self._report_refusals(statuses, events)
        answers = [
            answer if answer is not None and len(answer.data) == reading.length else None
            for answer in statuses
        ]
        if reading.length > length:
            answers = [answer and answer._replace(data=answer.data[-length:]) for answer in answers]
        self._quiet = not self._bus.in_step
        self._turn += self._quiet
        self._report_changes(answers, events)
        return answers

    def _report_refusals(self, statuses: Sequence[Status | None], events: list[str]) -> None:
        """Report every error with which a servo refuses the question, when it is new."""
        for place, status in enumerate(statuses):
            if status is None:
                continue
            refusal = self._bus.refusal(status)
            before, self._errors[place] = self._errors[place], status.error if refusal else 0
            if refusal and status.error != before:
                events.append(f"{refusal}: its values are not used")

    def _report_changes(self, answers: Sequence[Status | None], events: list[str]) -> None:
        answering = [answer is not None for answer in answers]
        if answering == self._answering:
            return
        names = [self._bus.names[servo] for servo in self._bus.servos]
        both = list(zip(names, self._answering, answering, strict=True))
        refused = {name for name, error in zip(names, self._errors, strict=True) if error}
        silent = ", ".join(name for name, before, now in both if before and not now and name not in refused)
        back = ", ".join(name for name, before, now in both if now and not before)
        events += [f"no whole answer from {silent}"] * bool(silent)
        events += [f"answers again from {back}"] * bool(back)
        self._answering = answering
