"""A diagnosis that was edited is read, or refused with the field, the value and what is expected."""

import json

import pytest

from exidyn.acquire.commands.view_command import view_of
from exidyn.acquire.files.result_files import read_shown
from exidyn.identification.errors import NotAFile

from ...parts.runs import parser_files


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "diagnosis.json"
    path.write_bytes(parser_files.diagnosis_files()["diagnosis.json"])
    return path


@pytest.mark.parametrize(
    ("places", "value", "told"),
    [
        (["seconds"], "long", "seconds: expected float, got str; found 'long'"),
        (["joints"], ["elbow", "elbow"], "joints[1]: expected a value not listed before; found 'elbow'"),
        (["findings", 0, "joints"], [3], ".joints[0]: expected the number of a joint, from 1 to 2; found 3"),
        (["findings", 0, "joints"], [1.0], "findings[0].joints[0]: expected int, got float; found 1.0"),
        (["findings", 0, "probability"], 1.5, "findings[0].probability: expected float <= 1.0; found 1.5"),
        (["findings", 0, "torque_rms"], [1.0], "[0].torque_rms: expected 2 values, one per joint; found 1"),
        (["findings", 0, "effect"], "Magic!", "findings[0].effect: expected str matching regex"),
        (["torque_units"], ["N m", "lbf"], "torque_units[1]: invalid enum value 'lbf'"),
        (["budget", "shares", 0, "percent"], [], "shares[0].percent: expected 2 values, one per joint"),
        (["budget", "shares", 0, "finding"], 9, "budget.shares[0].finding: expected the place of one of "),
        (["noise"], [0.0, 1.0], "noise[0]: expected a number above 0; found 0.0"),
        (["noise"], [float("nan"), 1.0], "noise: expected a number or null; found nan at [0]"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("read", [read_shown, lambda path: view_of([path])])
def test_a_wrong_field_is_named_with_its_value_and_what_is_expected(path, places, value, told, read):
    table = json.loads(path.read_text())
    *before, last = places
    holder = table
    for place in before:
        holder = holder[place]
    assert last in holder or isinstance(holder, list)
    holder[last] = value
    path.write_text(json.dumps(table))
    with pytest.raises(NotAFile) as error:
        read(path)
    assert str(error.value).startswith(f"{path}: ")
    assert told in str(error.value)
