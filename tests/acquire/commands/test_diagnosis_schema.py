"""A diagnosis that was edited is read, or refused with the field, the value and what is expected."""

import json

import pytest

from exidyn.acquire.files.report_files import read_diagnosed
from exidyn.acquire.views.kinds import view_of
from exidyn.identification.errors import NotAFile

from ...parts.runs import parser_files


@pytest.fixture
def path(tmp_path):
    (tmp_path / "diagnosis.json").write_bytes(parser_files.diagnosis_files()["diagnosis.json"])
    return tmp_path / "diagnosis.json"


@pytest.mark.parametrize(
    ("places", "value", "told"),
    [
        (["seconds"], "long", "seconds: expected float, got str; found 'long'"),
        (["joints"], ["shoulder"], "expected the number of a joint, from 1 to 1; found 2"),
        (["joints"], ["elbow", "elbow"], "joints[1]: expected a value not listed before; found 'elbow'"),
        (["findings", 0, "joints"], [3], ".joints[0]: expected the number of a joint, from 1 to 2; found 3"),
        (["findings", 0, "joints"], [1.0], "findings[0].joints[0]: expected int, got float; found 1.0"),
        (["findings", 0, "joints"], [0], "findings[0].joints[0]: expected int >= 1; found 0"),
        (["findings", 0, "probability"], 1.5, "findings[0].probability: expected float <= 1.0; found 1.5"),
        (["findings", 0, "torque_rms"], [1.0], "[0].torque_rms: expected 2 values, one a joint; found 1"),
        (["findings", 0, "effect"], "Magic!", "findings[0].effect: expected str matching regex"),
        (["changes"], [{"effect": "payload"}], "changes[0]: key 'joints' is missing"),
        (["budget", "units"], ["N m"], "budget.units: expected 2 values, one a joint; found 1"),
        (["budget", "units"], ["N m", "lbf"], "budget.units[1]: invalid enum value 'lbf'"),
        (["budget", "shares", 0, "percent"], [], "shares[0].percent: expected 2 values, one a joint"),
        (["budget", "shares", 0, "finding"], 9, "budget.shares[0].finding: expected the place of one of "),
        (["noise"], [0.0, 1.0], "noise[0]: expected float > 0.0; found 0.0"),
        (["noise"], [float("nan"), 1.0], "noise[0]: expected float > 0.0; found nan"),
        (["torque_rms_after"], [1.0], "torque_rms_after: expected 2 values, one a joint; found 1"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("read", [read_diagnosed, lambda path: view_of([path])])
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


def test_what_older_files_lack_has_a_default(path):
    table = json.loads(path.read_text())
    later = (
        "budget", "torque_units", "undecided", "moments", "changes", "noise_measured_at_rest", "simulated",
    )  # fmt: skip
    kept = {key: value for key, value in table.items() if key not in later}
    kept["doubts"] = kept.pop("warnings")
    for one in kept["remainders"]:
        one.pop("left")
    path.write_text(json.dumps(kept))
    page = read_diagnosed(path)[0]
    assert page.file.budget is None
    assert page.file.units == ("N m", "N m")
    assert len(page.file.findings) == len(table["findings"])
    assert page.file.limits == tuple(table["warnings"])
