"""Servos on a serial line: ask them, command them, and never mistake an old answer for a new one.

Answers carry no number. An answer that arrives after its deadline would be read in the next cycle, look
right, and make all later answers late. So each question first checks whether bytes are waiting already, and
then whether more bytes came than requested. If so, the line is left alone until it is silent.
"""

from collections.abc import Mapping, Sequence

from ..errors import LinkLost, NotReady
from ..host_clock import AnswerTime
from .serial_port import SerialPort
from .servo_line import Codec, Parsed, Reading, Register, Status

TRIES = 3
"""Number of attempts to ask a question or write a setting before the run."""


class ServoBus:
    """The servos of an arm on an open port: `names` by id, in the order of the joints."""

    def __init__(self, port: SerialPort, codec: Codec, names: Mapping[int, str]) -> None:
        self.port, self._codec, self.names = port, codec, dict(names)
        self.servos = tuple(self.names)  # ids of the servos
        self.clock = port.clock
        self.in_step = True  # whether the last answers were complete, in order, and followed by nothing

    def send_only(self, packets: bytes) -> None:
        """Send packets that have no answer. Raises LinkLost if the port is gone."""
        if packets:
            self.port.write(packets)

    def drain(self) -> int:
        """Discard unsolicited bytes, and return their number. Raises LinkLost if the port is gone."""
        return self.port.drain()

    def ask(
        self, reading: Reading, before: bytes = b"", answer_time: AnswerTime | None = None
    ) -> list[Status | None]:
        """Ask a question and return the answers in its order; None for a missing or invalid answer.

        Packets in `before` are sent ahead of the question, in the same write. `answer_time` is the usual
        time to its answers, None for a rare question. Raises LinkLost if the port is gone.
        """
        self.port.write(before + reading.packet)
        if answer_time is not None:
            answer_time.sleep()
        count, size = len(reading.servos), reading.answer_bytes
        data = self.port.read(size)
        if answer_time is not None and len(data) == size:
            answer_time.adjust(self.port.waited)
        parsed = reading.parse(data)
        while size <= len(data) < 2 * size and len(parsed.statuses) + parsed.broken < count:
            more = self.port.read(1)  # byte stuffing makes answers longer than expected
            if not more:
                break
            data += more
            parsed = reading.parse(data)
        servos = tuple(status.servo for status in parsed.statuses)
        if servos == reading.servos:
            self.in_step = not self.port.waiting
            return list(parsed.statuses) if self.in_step else [None] * count
        return self._sort(reading, parsed, len(data) >= size)

    def _sort(self, reading: Reading, parsed: Parsed, long_enough: bool) -> list[Status | None]:
        """Sort incomplete or unordered answers, in the form that `ask` returns."""
        count = len(reading.servos)
        places = [
            reading.servos.index(s.servo) if s.servo in reading.servos else count for s in parsed.statuses
        ]
        in_order = all(a < b for a, b in zip(places, [*places[1:], count], strict=False))
        orderly = in_order and not self.port.waiting
        self.in_step = orderly and long_enough and len(parsed.statuses) + parsed.broken >= count
        answers: list[Status | None] = [None] * count
        if orderly:
            for place, status in zip(places, parsed.statuses, strict=True):
                answers[place] = status
        return answers

    def ping(self, servo: int) -> bytes | None:
        """Ping a servo and return its data; None without an answer. Raises LinkLost if the port is gone."""
        for _ in range(TRIES):
            self.drain()
            question = self._codec.ping(servo)
            answer = self.ask(question)[0]
            if answer is not None and len(answer.data) == question.length:
                return answer.data
        return None

    def find(self, baudrate: int, baudrates: Sequence[int]) -> list[bytes]:
        """Ping all servos and return their data.

        `baudrate` is that of the port, `baudrates` are those that the servos support [bit/s]. Raises LinkLost
        if some servos do not answer, NotReady if the adapter echoes.
        """
        self._require_no_echo()
        answers = {servo: self.ping(servo) for servo in self.servos}
        received = [data for data in answers.values() if data is not None]
        if len(received) == len(answers):
            return received
        silent = ", ".join(self.names[servo] for servo, data in answers.items() if data is None)
        there = ", ".join(str(servo) for servo, data in answers.items() if data is not None) or "none"
        others = ", ".join(str(rate) for rate in baudrates if rate != baudrate)
        raise LinkLost(
            f"{silent} did not answer at {baudrate} bit/s; {there} did. Look at plugs, power and ids, or try "
            f"another baudrate: {others}"
        )

    def _require_no_echo(self) -> None:
        """Raise NotReady if the adapter echoes: a ping can look like the answer of a servo with an alarm."""
        question = self._codec.sync_read(0, 1, self.servos)
        self.drain()
        self.send_only(question.packet)
        if self.port.read(len(question.packet) + question.answer_bytes).startswith(question.packet):
            raise NotReady(
                "the adapter echoes, so that questions look like answers. Try an adapter that listens only "
                "while it does not send, such as those of the servos' makers"
            )

    def read(self, register: Register) -> list[int]:
        """Read a register of all servos. Raises LinkLost if some do not answer, or refuse."""
        for _ in range(TRIES):
            answers = self._answers(register)
            values = [_number(answer, register) for answer in answers]
            known = [value for value in values if value is not None]
            if len(known) == len(self.servos):
                return known
        texts = [
            f"{self.names[servo]} is silent" if answer is None else self.refusal(answer)
            for servo, answer, value in zip(self.servos, answers, values, strict=True)
            if value is None
        ]
        raise LinkLost(f"{register} cannot be read: {', '.join(texts)}. Look at plugs and power")

    def refusal(self, answer: Status) -> str:
        """Which servo refuses a question, and why; empty if the answer has valid data."""
        meaning = self._codec.refusal(answer.error)
        return f"{self.names[answer.servo]} answers with {meaning}" if meaning else ""

    def require(self, register: Register, value: int, advice: str) -> None:
        """Raise NotReady if a servo has another value, LinkLost if some do not answer."""
        for servo, actual in zip(self.servos, self.read(register), strict=True):
            if actual != value:
                raise NotReady(f"{self.names[servo]} is in {register.name} {actual}, not {value} {advice}")

    def peek(self, register: Register) -> list[int | None]:
        """Read a register of all servos in one attempt; None for silent servos.

        Raises LinkLost if the port is gone.
        """
        return [_number(answer, register) for answer in self._answers(register)]

    def _answers(self, register: Register) -> list[Status | None]:
        self.drain()
        return self.ask(self._codec.sync_read(register.address, register.size, self.servos))

    def packet(self, register: Register, values: Sequence[int]) -> bytes:
        """Packet that sets a register of all servos."""
        blocks = dict(zip(self.servos, map(register.encode, values), strict=True))
        return self._codec.sync_write(register.address, blocks)

    def set_checked(self, register: Register, values: Sequence[int], pause: float = 0.0) -> None:
        """Set a register of all servos and read it back, after a pause for slow memory [s].

        Raises LinkLost if some do not answer, NotReady if some do not take the value.
        """
        wrong: list[str] = []
        for _ in range(TRIES):
            self.send_only(self.packet(register, values))
            self.clock.sleep(pause)
            wrong = [
                f"{self.names[servo]} has {actual} instead of {value}"
                for servo, value, actual in zip(self.servos, values, self.read(register), strict=True)
                if actual != value
            ]
            if not wrong:
                return
        raise NotReady(f"{register} is not taken: {', '.join(wrong)}")


def _number(answer: Status | None, register: Register) -> int | None:
    """Value of a register in an answer; None without a valid answer."""
    if answer is None or len(answer.data) != register.size:
        return None
    return register.decode(answer.data)


LENGTHS = 4
"""Number of questions of different lengths."""

LOST = 100
"""Number of exchanges without any answer after which the link is lost."""


class ServoTalk:
    """Exchanges packets with the servos in the cycles of a run.

    After an incomplete answer or unsolicited bytes, one cycle sends only goals and asks nothing. The next
    question requests another number of bytes, so that a late answer to an earlier question cannot be mistaken
    for its answer.
    """

    def __init__(self, bus: ServoBus) -> None:
        self._bus = bus
        self._quiet, self._mute, self._turn = False, 0, 0
        self._answering = [True] * len(bus.servos)
        self._errors = [0] * len(bus.servos)
        self._answer_time = AnswerTime(bus.clock)

    def exchange(self, packets: bytes, readings: Sequence[Reading], events: list[str]) -> list[Status | None]:
        """Send packets, ask, and return the answers; None for each servo without an answer.

        `readings` contains the question, and variants with more and more bytes in front, `LENGTHS` in all.
        Events are added to `events`. Raises LinkLost if the port is gone, or if nothing has answered for a
        long time.
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
        """Report every new error with which a servo refuses the question."""
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
        changes = list(zip(names, self._answering, answering, strict=True))
        refused = {name for name, error in zip(names, self._errors, strict=True) if error}
        silent = ", ".join(
            name for name, before, now in changes if before and not now and name not in refused
        )
        back = ", ".join(name for name, before, now in changes if now and not before)
        events += [f"no complete answer from {silent}"] * bool(silent)
        events += [f"answers again from {back}"] * bool(back)
        self._answering = answering
