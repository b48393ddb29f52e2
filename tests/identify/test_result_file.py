"""Result files: what is written is read back, and what cannot be is refused with its place."""

import json
from dataclasses import dataclass

import numpy as np
import pytest

from exidyn.identification.diagnosis import Diagnosis, Quantity
from exidyn.identification.diagnosis.words.verdict import verdict
from exidyn.identification.errors import NotAFile
from exidyn.identification.result_file import from_table, to_table
from exidyn.identification.schema import Real

from ..parts.small.small_diagnosis import diagnosis


@dataclass(frozen=True, eq=False)
class Row:
    joint: int
    joints: tuple[int, ...]
    values: np.ndarray
    number: Real = float("nan")


def test_joints_count_from_one_in_files_and_nan_is_null():
    row = Row(0, (1, 2), np.array([[1.0, np.nan], [np.inf, 2.0]]))
    table = to_table(row)
    assert table == {"joint": 1, "joints": [2, 3], "values": [[1.0, None], [None, 2.0]], "number": None}
    again = from_table(json.loads(json.dumps(table)), Row, "a.json")
    assert (again.joint, again.joints) == (0, (1, 2))
    np.testing.assert_array_equal(again.values, [[1.0, np.nan], [np.nan, 2.0]])
    assert np.isnan(again.number)


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("values", [1.0, "x"], "a.json: values: expected a number or null; found 'x' at [1]"),
        ("values", [[1.0], [1.0, 2.0]], "a.json: values: expected rows of one length"),
        ("values", 3, "a.json: values: expected a list of numbers, got int"),
        ("number", 1e400, "a.json: number: expected a number or null; found inf"),
        ("number", True, "a.json: number: expected a number or null; found True"),
        ("joint", "one", "a.json: joint: expected int, got str; found 'one'"),
    ],
)
def test_a_wrong_value_is_refused_with_its_place(key, value, told):
    table = to_table(Row(0, (), np.zeros(1))) | {key: value}
    with pytest.raises(NotAFile) as error:
        from_table(table, Row, "a.json")
    assert str(error.value) == told


@pytest.mark.slow
def test_a_diagnosis_is_its_file():
    table = json.loads(json.dumps(to_table(diagnosis()), allow_nan=False))
    again = from_table(table, Diagnosis, "diagnosis.json")
    assert to_table(again) == table
    [spring] = again.findings
    assert isinstance(spring["Ks2"], Quantity)
    assert spring.joints == (1,)
    assert spring.term is None
    assert verdict(again) == verdict(diagnosis())
