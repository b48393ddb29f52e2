"""What a schema tells of a wrong value, and which matrices are covariances."""

import numpy as np
import pytest
from msgspec import Struct

from exidyn.identification.errors import NotAFile, RobotError
from exidyn.identification.schema import (
    Count,
    Disagreement,
    EffectName,
    Number,
    Probability,
    check_covariance,
    check_different,
    check_joints,
    checked,
)


class Inner(Struct, frozen=True):
    place: Count
    values: dict[str, Number] = {}

    def __post_init__(self) -> None:
        check_different(list(self.values.values()), "values")


class Outer(Struct, frozen=True):
    rows: tuple[Inner, ...]
    share: Probability = 0.0
    effect: EffectName = "none"


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ([], "expected object, got array; found []"),
        ({}, "key 'rows' is missing"),
        ({"rows": [{}]}, "rows[0]: key 'place' is missing"),
        ({"rows": [{"place": 0}, {"place": -1}]}, "rows[1].place: expected int >= 0; found -1"),
        ({"rows": [{"place": True}]}, "rows[0].place: expected int, got bool; found True"),
        ({"rows": [{"place": 1, "values": {"a": "b"}}]}, "rows[0].values[...]: expected float, got str"),
        ({"rows": [{"place": 1, "values": {"a": 1e101}}]}, "rows[0].values[...]: expected float <= 1e+100"),
        (
            {"rows": [{"place": 1, "values": {"a": 1.0, "b": 1.0}}]},
            "rows[0]: values[1]: expected a value not listed before",
        ),
        ({"rows": [], "share": float("nan")}, "share: expected float >= 0.0; found nan"),
        ({"rows": [], "effect": "x" * 500}, "effect: expected str matching regex"),
        ({"rows": {str(k): k for k in range(99)}}, "rows: expected array, got object; found dict of 99"),
    ],
)
def test_a_message_names_the_field_what_is_expected_and_the_value(table, told):
    with pytest.raises(NotAFile) as error:
        checked(table, Outer, "file.json")
    assert str(error.value).startswith(f"file.json: {told}")
    assert len(str(error.value)) < 200


def test_what_is_right_is_read_and_what_is_wrong_has_its_kind():
    read = checked({"rows": [{"place": 2, "values": {"a": 1}}], "more": 3}, Outer, "file.json")
    assert read == Outer((Inner(2, {"a": 1.0}),))
    with pytest.raises(RobotError):
        checked({}, Outer, "file.json", RobotError)


@pytest.mark.parametrize("size", [1e-40, 1.0, 1e40])
def test_covariances_are_taken_whatever_their_size_and_rank(size):
    random = np.random.default_rng(0)
    for rank in (0, 1, 3, 6):
        spread = size * random.normal(size=(6, rank)) * 10.0 ** np.arange(6)[:, None]
        check_covariance((spread @ spread.T).tolist(), "covariance")


@pytest.mark.parametrize(
    ("matrix", "told"),
    [
        ([[1.0, 0.0], [0.0, -1e-9]], r"covariance\[1\]\[1\]: expected a variance of zero or above; found"),
        ([[1.0, 0.5], [0.4, 1.0]], r"covariance\[0\]\[1\]: expected 0.4, which is covariance.*; found 0.5"),
        ([[1.0, 2.0], [2.0, 1.0]], r"covariance\[0\]\[1\]: expected at most 1 in size, .*; found 2.0"),
        ([[0.0, 0.1], [0.1, 1.0]], r"covariance\[0\]\[1\]: expected at most 0 in size, .*; found 0.1"),
        ([[1.0, 0.9, -0.9], [0.9, 1.0, 0.9], [-0.9, 0.9, 1.0]], "covariance: expected correlations without"),
    ],
)  # fmt: skip
def test_what_is_no_covariance_is_refused(matrix, told):
    with pytest.raises(Disagreement, match=told):
        check_covariance(matrix, "covariance")


def test_joints_count_from_one():
    check_joints([1, 3], "joints", 3)
    for numbers in ([4], [2, 2]):
        with pytest.raises(Disagreement, match=r"joints\[\d\]: expected"):
            check_joints(numbers, "joints", 3)
