import pytest

from exidyn.drivers.errors import BadSettings
from exidyn.drivers.servo.servo_line import Traffic

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
