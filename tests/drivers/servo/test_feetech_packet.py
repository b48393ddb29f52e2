import random

import pytest

from exidyn.drivers.feetech import packet as packets
from exidyn.drivers.servo.servo_line import Status

# Published by the manufacturer beside the description of each instruction.
ANSWERS = "FF FF 01 0A 00 00 08 00 00 00 00 79 1E 55 FF FF 02 0A 00 FF 07 00 00 00 00 77 23 53"
SYNC_WRITE = (
    "FF FF FE 20 83 2A 06 01 00 08 00 00 E8 03 02 00 08 00 00 E8 03 03 00 08 00 00 E8 03 "
    "04 00 08 00 00 E8 03 58"
)


def test_packets_are_the_published_ones():
    move = bytes.fromhex("00 08 00 00 E8 03")
    assert packets.ping(1).packet == bytes.fromhex("FF FF 01 02 01 FB")
    assert packets.packet(1, 2, b"\x38\x02") == bytes.fromhex("FF FF 01 04 02 38 02 BE")
    assert packets.packet(1, 3, b"\x2a" + move) == bytes.fromhex("FF FF 01 09 03 2A 00 08 00 00 E8 03 D5")
    assert packets.sync_read(0x38, 8, (1, 2)).packet == bytes.fromhex("FF FF FE 06 82 38 08 01 02 36")
    assert packets.sync_write(0x2A, dict.fromkeys((1, 2, 3, 4), move)) == bytes.fromhex(SYNC_WRITE)


def test_published_answers_are_understood():
    assert packets.ping(1).parse(bytes.fromhex("FF FF 01 02 00 FC")).statuses == [Status(1, 0, b"")]
    assert packets.parse(bytes.fromhex("FF FF 01 04 00 18 05 DD"), 2).statuses == [Status(1, 0, b"\x18\x05")]
    reading = packets.sync_read(0x38, 8, (1, 2))
    found = reading.parse(bytes.fromhex(ANSWERS))
    assert [status.servo for status in found.statuses] == [1, 2]
    assert found.statuses[1].data == bytes.fromhex("FF 07 00 00 00 00 77 23")
    assert reading.answer_bytes == len(bytes.fromhex(ANSWERS))


@pytest.mark.parametrize("bit", range(8))
def test_no_answer_with_a_wrong_bit_is_accepted(bit):
    good = bytes.fromhex(ANSWERS)
    for place in range(14):
        wrong = bytearray(good)
        wrong[place] ^= 1 << bit
        assert [status.servo for status in packets.parse(bytes(wrong), 8).statuses] == [2]


def test_a_header_in_the_data_or_before_it_misleads_nobody():
    tricky = packets.packet(1, 0, b"\xff\xff\x01\x0a\xff\xff\xff\xff")
    found = packets.parse(b"\xff\xff" + tricky + packets.packet(2, 0, bytes(8)), 8)
    assert found.statuses == [Status(1, 0, b"\xff\xff\x01\x0a\xff\xff\xff\xff"), Status(2, 0, bytes(8))]


def test_arbitrary_bytes_raise_nothing():
    chance = random.Random(1)
    for _ in range(3000):
        data = bytes(chance.choice((0xFF, 2, chance.randrange(256))) for _ in range(chance.randrange(60)))
        assert len(packets.parse(data, 2).statuses) <= 2
