"""A line that a test writes by hand: old answers, bytes that were not asked for, silence; and its rate."""

import random

import pytest

from exidyn.drivers.errors import BadSettings, LinkLost
from exidyn.drivers.feetech import packet as packets
from exidyn.drivers.host_clock import HOST
from exidyn.drivers.servo.servo_bus import LENGTHS, LOST, ServoBus, ServoTalk
from exidyn.drivers.servo.servo_line import Traffic

READINGS = [packets.sync_read(56 - more, 2 + more, (1, 2, 3)) for more in range(LENGTHS)]
GOALS = b"goals"


class Line:
    """A port whose other end is a list of what comes, one entry a question."""

    waited, clock = False, HOST

    def __init__(self):
        self.came, self.sent = b"", []

    def write(self, data):
        self.sent.append(data)
        self.came += self.answers(data)

    def answers(self, data):
        return b""

    def read(self, count):
        data, self.came = self.came[:count], self.came[count:]
        return data

    @property
    def waiting(self):
        return len(self.came)

    def drain(self):
        return len(self.read(self.waiting))


def answers(value, servos=(1, 2, 3), turn=0):
    """To the question of that turn."""
    return b"".join(packets.packet(servo, 0, bytes([*bytes(turn), value, servo])) for servo in servos)


@pytest.fixture
def line():
    return Line()


@pytest.fixture
def talk(line):
    return ServoTalk(ServoBus(line, packets, {1: "one", 2: "two", 3: "three"}))


def exchange(talk, line, answer=b""):
    """First byte of each servo's answer, None for none, and events."""
    line.answers = lambda data: b"" if data == GOALS else answer
    events = []
    found = talk.exchange(GOALS, READINGS, events)
    return [None if one is None else one.data[-2] for one in found], events


def test_goals_and_question_are_one_write(talk, line):
    assert exchange(talk, line, answers(7)) == ([7, 7, 7], [])
    assert line.sent == [GOALS + READINGS[0].packet]


NO_ANSWERS = [None] * 3


def test_a_late_answer_is_never_taken_for_the_next(talk, line):
    assert exchange(talk, line)[0] == NO_ANSWERS  # nothing comes in time
    line.came = answers(1)  # now it does
    assert exchange(talk, line, answers(2))[0] == NO_ANSWERS
    assert line.sent[-1] == GOALS  # and nothing was asked
    assert exchange(talk, line, answers(3))[0] == NO_ANSWERS  # until the line was silent
    assert exchange(talk, line, answers(4, turn=1)) == ([4, 4, 4], ["answers again from one, two, three"])


def test_answers_that_are_always_a_question_late_are_never_accepted(talk, line):
    asked = []

    def late(data):
        turns = [turn for turn, reading in enumerate(READINGS) if reading.packet in data]
        asked.extend(turns)
        return answers(7, turn=asked[-2]) if turns and len(asked) > 1 else b""

    line.answers = late
    for _ in range(60):
        assert talk.exchange(GOALS, READINGS, []) == NO_ANSWERS
    assert len(asked) > 10


def test_a_question_after_trouble_is_of_another_length(talk, line):
    asked = []
    for _ in range(LENGTHS):
        exchange(talk, line)
        asked.append(line.sent[-1])
        exchange(talk, line)
    assert asked == [GOALS + reading.packet for reading in READINGS]


def test_an_old_answer_in_front_of_the_right_one_is_passed_over_or_all_is_left(talk, line):
    exchange(talk, line)
    exchange(talk, line)
    assert 1 not in exchange(talk, line, answers(1) + answers(2, turn=1))[0]
    assert exchange(talk, line, answers(3, turn=2))[0] == NO_ANSWERS
    assert exchange(talk, line, answers(4, turn=2))[0] == NO_ANSWERS
    assert exchange(talk, line, answers(5, turn=2))[0] == [5, 5, 5]


def test_bytes_that_nobody_asked_for_are_reported_once(talk, line):
    line.came = b"???"
    first = exchange(talk, line, answers(1))
    line.came = b"???"
    second = exchange(talk, line, answers(2))
    assert first == (NO_ANSWERS, ["3 bytes came unasked; nothing is asked until the line is silent"])
    assert second == (NO_ANSWERS, [])


@pytest.mark.parametrize("servos", [(3, 1, 2), (1, 1, 2), (1, 2, 9)])
def test_answers_out_of_order_or_twice_or_of_somebody_else_are_not_accepted(talk, line, servos):
    assert exchange(talk, line, answers(5, servos))[0] == NO_ANSWERS


def test_a_servo_whose_answer_is_broken_costs_nobody_else_a_cycle(talk, line):
    wrong = bytearray(answers(5))
    wrong[-1] ^= 1
    assert exchange(talk, line, bytes(wrong)) == ([5, 5, None], ["no complete answer from three"])
    assert exchange(talk, line, answers(6)) == ([6, 6, 6], ["answers again from three"])


def test_a_silent_servo_leaves_the_others(talk, line):
    for turn in range(3):
        assert exchange(talk, line, answers(5, (1, 3), turn))[0] == [5, None, 5]
        assert exchange(talk, line, answers(5, (1, 3), turn))[0] == NO_ANSWERS  # it might come yet


def test_long_silence_is_a_lost_link(talk, line):
    for _ in range(LOST):
        exchange(talk, line)
    with pytest.raises(LinkLost, match=f"no servo has answered {LOST} times"):
        exchange(talk, line)


def test_whatever_comes_only_our_errors_are_raised(talk, line):
    chance = random.Random(0)
    for _ in range(2000):
        noise = chance.randbytes(chance.randrange(40))
        pick = chance.choice((answers(3), noise, answers(3)[:-3], noise + answers(3), answers(3) + noise))
        try:
            found, _ = exchange(talk, line, pick)
        except LinkLost:
            continue
        assert set(found) <= {3, None}


SIX = Traffic(64, 126, 6)


def test_every_byte_takes_ten_bits_and_every_answer_its_delay():
    assert SIX.seconds(1_000_000) == pytest.approx(1.90e-3)
    assert Traffic(64, 126, 6, 500e-6, 1e-3).seconds(4_000_000) == pytest.approx(0.475e-3 + 3e-3 + 1e-3)


@pytest.mark.parametrize(
    ("baudrate", "cycle"), [(1_000_000, 0.0022), (2_000_000, 0.0011), (4_000_000, 0.0006)]
)
def test_the_shortest_cycle_leaves_the_computer_a_tenth(baudrate, cycle):
    assert SIX.shortest_cycle(baudrate) == pytest.approx(cycle)


def test_what_the_line_can_just_carry_is_taken():
    Traffic(90, 90, 6).require_rate(0.002, 1_000_000, "")


def test_what_it_cannot_carry_is_refused_with_numbers():
    with pytest.raises(BadSettings, match="64 bytes out and 126 back.*1.90 ms.*cycle of 0.0022 s, or pray"):
        SIX.require_rate(0.002, 1_000_000, "or pray")
