"""Packets of both servo protocols: as their makers publish them, broken, and arbitrary bytes."""

import random

import pytest

from exidyn.drivers.dynamixel import packet as dynamixel
from exidyn.drivers.feetech import packet as feetech
from exidyn.drivers.servo.servo_line import Status

# Published by the manufacturer beside the description of each instruction.
PING = "FF FF FD 00 01 03 00 01 19 4E"
PONG = "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D"
WRITE = "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89"
SYNC_READ = "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA"
ANSWERS = "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0 FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE"
SYNC_WRITE = "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87"
FAST = "FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2"
JOINED = "FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08 00 07 1F 08 00 00 16 CA 00 04 FF 03 00 00 D1 9E"
REFUSED = dynamixel.packet(1, dynamixel.STATUS, b"\x07")
FEETECH_ANSWERS = "FF FF 01 0A 00 00 08 00 00 00 00 79 1E 55 FF FF 02 0A 00 FF 07 00 00 00 00 77 23 53"
FEETECH_SYNC_WRITE = (
    "FF FF FE 20 83 2A 06 01 00 08 00 00 E8 03 02 00 08 00 00 E8 03 03 00 08 00 00 E8 03 "
    "04 00 08 00 00 E8 03 58"
)


def value(number, size=4):
    return number.to_bytes(size, "little")


def test_packets_are_the_published_ones():
    assert dynamixel.ping(1).packet == bytes.fromhex(PING)
    assert dynamixel.packet(1, 3, b"\x74\x00" + value(512)) == bytes.fromhex(WRITE)
    assert dynamixel.sync_read(132, 4, (1, 2)).packet == bytes.fromhex(SYNC_READ)
    assert dynamixel.sync_write(116, {1: value(150), 2: value(170)}) == bytes.fromhex(SYNC_WRITE)
    assert dynamixel.fast_sync_read(132, 4, (3, 7, 4)).packet == bytes.fromhex(FAST)


def test_published_answers_are_understood():
    ping = dynamixel.ping(1)
    assert ping.parse(bytes.fromhex(PONG)).statuses == [Status(1, 0, b"\x06\x04\x26")]
    assert ping.answer_bytes == len(bytes.fromhex(PONG))
    reading = dynamixel.sync_read(132, 4, (1, 2))
    assert reading.parse(bytes.fromhex(ANSWERS)) == ([Status(1, 0, value(166)), Status(2, 0, value(2079))], 0)
    assert reading.answer_bytes == len(bytes.fromhex(ANSWERS))


def test_published_joined_answers_are_understood():
    reading = dynamixel.fast_sync_read(132, 4, (3, 7, 4))
    found = reading.parse(bytes.fromhex(JOINED))
    assert found == ([Status(3, 0, value(166)), Status(7, 0, value(2079)), Status(4, 0, value(1023))], 0)
    assert reading.answer_bytes == len(bytes.fromhex(JOINED))


@pytest.mark.parametrize(("place", "left"), [(11, 0), (19, 1), (26, 2), (31, 2)])
def test_joined_answers_before_a_wrong_bit_are_whole(place, left):
    data = bytearray.fromhex(JOINED)
    data[place] ^= 1
    found = dynamixel.fast_sync_read(132, 4, (3, 7, 4)).parse(bytes(data))
    assert len(found.statuses) == left
    assert found.broken == 3 - left


def test_what_looks_like_a_header_is_stuffed():
    assert dynamixel.packet(1, 3, b"\x74\x00\xff\xff\xfd\xff").hex() == "fffffd00010a00037400fffffdfdff23e5"


def test_any_data_come_back_as_they_went():
    chance = random.Random(0)
    for _ in range(3000):
        data = bytes(chance.choice((0xFF, 0xFF, 0xFD, chance.randrange(256))) for _ in range(10))
        sent = dynamixel.packet(5, dynamixel.STATUS, b"\0" + data)
        assert sent.find(b"\xff\xff\xfd", 7) in (
            -1,
            sent.find(b"\xff\xff\xfd\xfd", 7),
            len(sent) - 3,
            len(sent) - 4,
        )
        assert dynamixel.parse(sent, 10).statuses == [Status(5, 0, data)]


def test_a_servo_that_refuses_reports_it_without_data():
    assert dynamixel.parse(REFUSED, 4).statuses == [Status(1, 7, b"")]


@pytest.mark.parametrize("alert", [0, dynamixel.ALERT])
@pytest.mark.parametrize("number", [1, 7, 0x7F])
def test_data_beside_an_error_number_are_none(number, alert):
    error = number | alert
    answer = dynamixel.packet(1, dynamixel.STATUS, bytes([error]) + value(166))
    assert dynamixel.parse(answer, 4).statuses == [Status(1, error, b"")]
    head = dynamixel.HEADER + bytes([dynamixel.EVERYBODY, 9, 0, dynamixel.STATUS])
    joined = head + bytes([error, 3]) + value(166)
    reading = dynamixel.fast_sync_read(132, 4, (3,))
    statuses = reading.parse(joined + dynamixel.crc(joined).to_bytes(2, "little")).statuses
    assert statuses == [Status(3, error, b"")]
    assert dynamixel.refusal(error).startswith(f"error {number} (")
    assert dynamixel.refusal(error).endswith("and a hardware error") == bool(alert)


def test_an_alert_alone_leaves_the_data():
    answer = dynamixel.packet(1, dynamixel.STATUS, bytes([dynamixel.ALERT]) + value(166))
    assert dynamixel.parse(answer, 4).statuses == [Status(1, dynamixel.ALERT, value(166))]
    assert dynamixel.refusal(dynamixel.ALERT) == dynamixel.refusal(0) == ""


def test_garbage_before_and_between_answers_is_passed_over():
    first, second = bytes.fromhex(ANSWERS)[:15], bytes.fromhex(ANSWERS)[15:]
    data = b"\xff\xff\xfd\x00" + first + b"\xff\xfd\x00\x55" + second
    assert [status.servo for status in dynamixel.parse(data, 4).statuses] == [1, 2]


def test_feetech_packets_are_the_published_ones():
    move = bytes.fromhex("00 08 00 00 E8 03")
    assert feetech.ping(1).packet == bytes.fromhex("FF FF 01 02 01 FB")
    assert feetech.packet(1, 2, b"\x38\x02") == bytes.fromhex("FF FF 01 04 02 38 02 BE")
    assert feetech.packet(1, 3, b"\x2a" + move) == bytes.fromhex("FF FF 01 09 03 2A 00 08 00 00 E8 03 D5")
    assert feetech.sync_read(0x38, 8, (1, 2)).packet == bytes.fromhex("FF FF FE 06 82 38 08 01 02 36")
    assert feetech.sync_write(0x2A, dict.fromkeys((1, 2, 3, 4), move)) == bytes.fromhex(FEETECH_SYNC_WRITE)


def test_published_feetech_answers_are_understood():
    assert feetech.ping(1).parse(bytes.fromhex("FF FF 01 02 00 FC")).statuses == [Status(1, 0, b"")]
    assert feetech.parse(bytes.fromhex("FF FF 01 04 00 18 05 DD"), 2).statuses == [Status(1, 0, b"\x18\x05")]
    reading = feetech.sync_read(0x38, 8, (1, 2))
    found = reading.parse(bytes.fromhex(FEETECH_ANSWERS))
    assert [status.servo for status in found.statuses] == [1, 2]
    assert found.statuses[1].data == bytes.fromhex("FF 07 00 00 00 00 77 23")
    assert reading.answer_bytes == len(bytes.fromhex(FEETECH_ANSWERS))


def test_a_header_in_the_data_or_before_it_misleads_nobody():
    tricky = feetech.packet(1, 0, b"\xff\xff\x01\x0a\xff\xff\xff\xff")
    found = feetech.parse(b"\xff\xff" + tricky + feetech.packet(2, 0, bytes(8)), 8)
    assert found.statuses == [Status(1, 0, b"\xff\xff\x01\x0a\xff\xff\xff\xff"), Status(2, 0, bytes(8))]


@pytest.mark.parametrize(
    ("packets", "answers", "length", "may_lose"),
    [(dynamixel, ANSWERS, 4, True), (feetech, FEETECH_ANSWERS, 8, False)],
)
@pytest.mark.parametrize("bit", range(8))
def test_no_answer_with_a_wrong_bit_is_accepted(packets, answers, length, may_lose, bit):
    good = bytes.fromhex(answers)
    second = packets.parse(good, length).statuses[1:]
    for place in range(len(good) // 2):
        wrong = bytearray(good)
        wrong[place] ^= 1 << bit
        statuses = packets.parse(bytes(wrong), length).statuses
        assert statuses == second or (may_lose and statuses == [])


def test_arbitrary_bytes_are_nothing():
    chance = random.Random(1)
    joined = dynamixel.fast_sync_read(132, 4, (3, 7, 4)).parse
    for _ in range(3000):
        length = chance.randrange(60)
        data = bytes(chance.choice((0xFF, 0xFD, 0, 0x55, chance.randrange(256))) for _ in range(length))
        assert not dynamixel.parse(data, 4).statuses
        assert not joined(data).statuses
        data = bytes(chance.choice((0xFF, 2, chance.randrange(256))) for _ in range(length))
        assert len(feetech.parse(data, 2).statuses) <= 2
