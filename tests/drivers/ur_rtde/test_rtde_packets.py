"""Packages of RTDE: byte for byte as the protocol has them, in any pieces, and broken."""

import struct

import numpy as np
import pytest

from exidyn.drivers.ur_rtde.rtde import DATA, IN_USE, NOT_FOUND, Recipe, Unpacked, package, text_of

NAMES = ["timestamp", "actual_q", "robot_mode", "runtime_state", "joint_mode"]
TYPES = b"DOUBLE,VECTOR6D,INT32,UINT32,VECTOR6INT32"


def test_a_package_is_size_kind_and_body():
    assert package(b"V", b"\x00\x02") == b"\x00\x05V\x00\x02"


@pytest.mark.parametrize("piece", [1, 2, 5, 100])
def test_packages_come_out_of_any_pieces(piece):
    data = package(b"V", b"\x01") + package(DATA, b"abc") + package(b"S", b"")
    unpacked, found = Unpacked(), []
    for start in range(0, len(data), piece):
        found += unpacked.add(data[start : start + piece])
    assert found == [(b"V", b"\x01"), (DATA, b"abc"), (b"S", b"")]


def test_a_size_that_cannot_be_is_no_package():
    with pytest.raises(ValueError, match="2 bytes"):
        list(Unpacked().add(b"\x00\x02U"))


def test_data_are_read_by_the_recipe():
    recipe = Recipe(NAMES, b"\x07" + TYPES)
    body = struct.pack(">Bd6diI6i", 7, 12.5, *range(6), -1, 2, *[253] * 6)
    record = recipe.read(body)
    assert recipe.accepted
    assert record["timestamp"] == 12.5
    assert record["actual_q"].tolist() == list(range(6))
    assert (record["robot_mode"], record["runtime_state"]) == (-1, 2)
    assert record["joint_mode"].tolist() == [253] * 6
    for wrong in (body[:-1], body + b"\x00", b"\x08" + body[1:], b""):
        with pytest.raises(ValueError, match="expected"):
            recipe.read(wrong)


def test_inputs_are_written_by_the_recipe():
    recipe = Recipe(["input_double_register_24", "input_int_register_24"], b"\x01DOUBLE,INT32")
    values = {"input_double_register_24": -1.25, "input_int_register_24": 9}
    assert recipe.written(values) == struct.pack(">Bdi", 1, -1.25, 9)


def test_names_that_are_refused_are_listed():
    recipe = Recipe(["a", "b", "c"], b"\x00DOUBLE,NOT_FOUND,IN_USE")
    assert not recipe.accepted
    assert recipe.refused(NOT_FOUND) == ["b"]
    assert recipe.refused(IN_USE) == ["c"]
    with pytest.raises(ValueError, match="3 types for 2 names"):
        Recipe(["a", "b"], b"\x01DOUBLE,DOUBLE,DOUBLE")


def test_whatever_comes_raises_nothing_else():
    random = np.random.default_rng(0)
    for _ in range(500):
        data = random.bytes(int(random.integers(1, 60)))
        assert isinstance(text_of(data), str)
        try:
            list(Unpacked().add(data))
            Recipe(["a"], data)
        except ValueError:
            pass
