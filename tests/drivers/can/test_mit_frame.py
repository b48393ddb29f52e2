"""The MIT frame against an independent formulation, and its answers."""

import numpy as np
import pytest

from exidyn.drivers.can_mit.mit_frame import (
    DAMIAO,
    KD,
    KP,
    MODELS,
    T_MOTOR,
    Ranges,
    answering,
    error_text,
    pack,
    unpack,
)

RANGES = Ranges(12.5, 30.0, 10.0)


def by_shifts(p, v, kp, kd, t):
    """As the manuals have it, of whole numbers."""
    shared = (v & 15) << 4 | kp >> 8, (kd & 15) << 4 | t >> 8
    return bytes([p >> 8, p & 255, v >> 4, shared[0], kp & 255, kd >> 4, shared[1], t & 255])


def test_a_command_is_packed_as_the_manuals_draw_it():
    random = np.random.default_rng(0)
    for _ in range(500):
        p, (v, kp, kd, t) = int(random.integers(65536)), (int(one) for one in random.integers(4096, size=4))
        values = (
            12.5 * (2 * p / 65535 - 1), 30.0 * (2 * v / 4095 - 1), KP * kp / 4095, KD * kd / 4095,
            10.0 * (2 * t / 4095 - 1),
        )  # fmt: skip
        assert pack(RANGES, *values) == by_shifts(p, v, kp, kd, t)


def test_middle_and_ends_of_a_command():
    assert pack(RANGES, -12.5, -30.0, 0.0, 0.0, -10.0) == bytes(8)
    assert pack(RANGES, 12.5, 30.0, 500.0, 5.0, 10.0) == b"\xff" * 8
    assert pack(RANGES, 99.0, 99.0, 999.0, 9.0, 99.0) == b"\xff" * 8


@pytest.mark.parametrize("model", MODELS)
def test_an_answer_reports_what_was_measured_to_half_a_step(model):
    family, ranges = MODELS[model]
    random = np.random.default_rng(1)
    for _ in range(100):
        p, v, t = random.uniform(-1.0, 1.0, 3) * ranges
        body = pack(ranges, p, v, 0.0, 0.0, t)
        number = int.from_bytes(body, "big")
        answer = (number >> 48 << 24 | (number >> 36 & 0xFFF) << 12 | number & 0xFFF).to_bytes(5, "big")
        state = unpack(ranges, family, b"\x13" + answer + b"\x28\x2a")
        assert state is not None
        steps = np.array(ranges) / [65535.0, 4095.0, 4095.0]
        assert (np.abs(np.subtract((p, v, t), state[1:4])) <= steps * (1.0 + 1e-9)).all()


def test_the_two_makers_put_error_and_temperature_elsewhere():
    data = bytes([0x93, 0x80, 0, 0x80, 0x08, 0, 30, 41])
    damiao = unpack(RANGES, DAMIAO, data)
    other = unpack(RANGES, T_MOTOR, bytes([0x93, 0x80, 0, 0x80, 0x08, 0, 0xF6, 2]))
    short = unpack(RANGES, T_MOTOR, data[:6])
    assert (damiao.error, damiao.temperature, answering(DAMIAO, data)) == (9, 41.0, 3)
    assert (other.error, other.temperature, answering(T_MOTOR, data)) == (2, -10.0, 0x93)
    assert (short.error, np.isnan(short.temperature)) == (0, True)


@pytest.mark.parametrize("length", [0, 1, 5, 7])
def test_what_is_no_answer_is_none(length):
    assert unpack(RANGES, DAMIAO, bytes(length)) is None
    assert unpack(RANGES, T_MOTOR, bytes(length)) is None
    assert unpack(RANGES, DAMIAO, bytes(6)) is None


def test_errors_have_words():
    assert error_text(DAMIAO, 0) == error_text(DAMIAO, 1) == error_text(T_MOTOR, 0) == ""
    assert error_text(DAMIAO, 13) == "error 13 (host silent)"
    assert error_text(T_MOTOR, 1) == "error 1 (motor too hot)"
    assert error_text(T_MOTOR, 99) == "error 99 (unknown)"
