import random

import pytest

from exidyn.drivers.dynamixel import packet as packets
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
REFUSED = packets.packet(1, packets.STATUS, b"\x07")


def value(number, size=4):
    return number.to_bytes(size, "little")


def test_packets_are_the_published_ones():
    assert packets.ping(1).packet == bytes.fromhex(PING)
    assert packets.packet(1, 3, b"\x74\x00" + value(512)) == bytes.fromhex(WRITE)
    assert packets.sync_read(132, 4, (1, 2)).packet == bytes.fromhex(SYNC_READ)
    assert packets.sync_write(116, {1: value(150), 2: value(170)}) == bytes.fromhex(SYNC_WRITE)
    assert packets.fast_sync_read(132, 4, (3, 7, 4)).packet == bytes.fromhex(FAST)


def test_published_answers_are_understood():
    ping = packets.ping(1)
    assert ping.parse(bytes.fromhex(PONG)).statuses == [Status(1, 0, b"\x06\x04\x26")]
    assert ping.answer_bytes == len(bytes.fromhex(PONG))
    reading = packets.sync_read(132, 4, (1, 2))
    assert reading.parse(bytes.fromhex(ANSWERS)) == ([Status(1, 0, value(166)), Status(2, 0, value(2079))], 0)
    assert reading.answer_bytes == len(bytes.fromhex(ANSWERS))


def test_published_joined_answers_are_understood():
    reading = packets.fast_sync_read(132, 4, (3, 7, 4))
    found = reading.parse(bytes.fromhex(JOINED))
    assert found == ([Status(3, 0, value(166)), Status(7, 0, value(2079)), Status(4, 0, value(1023))], 0)
    assert reading.answer_bytes == len(bytes.fromhex(JOINED))


@pytest.mark.parametrize(("place", "left"), [(11, 0), (19, 1), (26, 2), (31, 2)])
def test_joined_answers_before_a_wrong_bit_are_whole(place, left):
    data = bytearray.fromhex(JOINED)
    data[place] ^= 1
    found = packets.fast_sync_read(132, 4, (3, 7, 4)).parse(bytes(data))
    assert len(found.statuses) == left
    assert found.broken == 3 - left


def test_what_looks_like_a_header_is_stuffed():
    assert packets.packet(1, 3, b"\x74\x00\xff\xff\xfd\xff").hex() == "fffffd00010a00037400fffffdfdff23e5"


def test_any_data_come_back_as_they_went():
    chance = random.Random(0)
    for _ in range(3000):
        data = bytes(chance.choice((0xFF, 0xFF, 0xFD, chance.randrange(256))) for _ in range(10))
        sent = packets.packet(5, packets.STATUS, b"\0" + data)
        assert sent.find(b"\xff\xff\xfd", 7) in (
            -1,
            sent.find(b"\xff\xff\xfd\xfd", 7),
            len(sent) - 3,
            len(sent) - 4,
        )
        assert packets.parse(sent, 10).statuses == [Status(5, 0, data)]


def test_a_servo_that_refuses_reports_it_without_data():
    assert packets.parse(REFUSED, 4).statuses == [Status(1, 7, b"")]


@pytest.mark.parametrize("alert", [0, packets.ALERT])
@pytest.mark.parametrize("number", [1, 7, 0x7F])
def test_data_beside_an_error_number_are_none(number, alert):
    error = number | alert
    answer = packets.packet(1, packets.STATUS, bytes([error]) + value(166))
    assert packets.parse(answer, 4).statuses == [Status(1, error, b"")]
    head = packets.HEADER + bytes([packets.EVERYBODY, 9, 0, packets.STATUS])
    joined = head + bytes([error, 3]) + value(166)
    reading = packets.fast_sync_read(132, 4, (3,))
    statuses = reading.parse(joined + packets.crc(joined).to_bytes(2, "little")).statuses
    assert statuses == [Status(3, error, b"")]
    assert packets.refusal(error).startswith(f"error {number} (")
    assert packets.refusal(error).endswith("and a hardware error") == bool(alert)


def test_an_alert_alone_leaves_the_data():
    answer = packets.packet(1, packets.STATUS, bytes([packets.ALERT]) + value(166))
    assert packets.parse(answer, 4).statuses == [Status(1, packets.ALERT, value(166))]
    assert packets.refusal(packets.ALERT) == packets.refusal(0) == ""


@pytest.mark.parametrize("bit", range(8))
def test_no_answer_with_a_wrong_bit_is_accepted(bit):
    good = bytes.fromhex(ANSWERS)
    for place in range(15):
        wrong = bytearray(good)
        wrong[place] ^= 1 << bit
        assert packets.parse(bytes(wrong), 4).statuses in ([Status(2, 0, value(2079))], [])


def test_garbage_before_and_between_answers_is_passed_over():
    first, second = bytes.fromhex(ANSWERS)[:15], bytes.fromhex(ANSWERS)[15:]
    data = b"\xff\xff\xfd\x00" + first + b"\xff\xfd\x00\x55" + second
    assert [status.servo for status in packets.parse(data, 4).statuses] == [1, 2]


def test_arbitrary_bytes_are_nothing():
    chance = random.Random(1)
    joined = packets.fast_sync_read(132, 4, (3, 7, 4)).parse
    for _ in range(3000):
        data = bytes(
            chance.choice((0xFF, 0xFD, 0, 0x55, chance.randrange(256))) for _ in range(chance.randrange(60))
        )
        assert not packets.parse(data, 4).statuses
        assert not joined(data).statuses
