"""Files of exidyn that were edited by hand: what is wrong in one line, and never a Traceback."""

import json
import os
import re
import shutil
from pathlib import Path

import pytest

from exidyn.acquire.command_line import main
from exidyn.acquire.commands.view_command import view_of
from exidyn.acquire.files.result_files import read_shown
from exidyn.identification.errors import NotAFile, RobotError
from exidyn.identification.recordings.tables.preset import parse_preset

from ...parts.runs import parser_files

FOLDER = Path(os.environ.get("EXIDYN_INPUTS", Path(__file__).parents[3] / "../shared/inputs")) / "hostile"
EDITED = ("tb_diag_341fe426", "tb_diag_471e1ac3", "tb_fit_11c90a6b", "tb_fit_9d0125a9", "tb_fit_a30003a6",
          "tb_fit_d6a7995d")  # fmt: skip


@pytest.mark.parametrize("name", EDITED)
def test_an_edited_file_is_refused_in_one_line(name, tmp_path, monkeypatch, capsys):
    if not (FOLDER / name).is_dir():
        pytest.skip(f"no {name} in {FOLDER}; set EXIDYN_INPUTS to the folder of inputs")
    shutil.copytree(FOLDER / name, tmp_path / "input")
    monkeypatch.chdir(tmp_path / "input")
    told = Path("WHAT.md").read_text().splitlines()
    line = next(line for line in told if line.startswith("Command: exidyn "))
    command = line.split()[2:]
    if command[0] == "report":  # a command of older versions; `view` reads the same files
        command = ["view", command[1], "--save", "o/r.rrd"]
    Path("o").mkdir()
    assert main(command) == 2
    told = [line for line in capsys.readouterr().err.splitlines() if line.startswith("exidyn: ")]
    assert len(told) == 1
    where = r"(fit|diagnosis)\.json: [a-z_]+(\[\d+\])*[a-z_.\[\]\d]*"
    wrong = rf"{where}: expected .*; found |has format 1; |key '\w+' is missing"
    assert re.search(wrong, told[0])
    assert not list(Path("o").iterdir())


@pytest.mark.parametrize("sign", ["[1, [-1]]", "[[1], 1]", "[]", "{a = 1}", "[true]", "0", "nan"])
def test_signs_of_a_preset_are_numbers_of_one_and_minus_one(sign):
    text = f'[position]\ncolumn = "q"\nsign = {sign}\n'
    with pytest.raises(RobotError, match=r"^p: \[position\] sign(\[\d\])?: expected .*; found "):
        parse_preset(text, "p")


def test_columns_of_a_preset_are_no_empty_list():
    with pytest.raises(RobotError, match=r"^p: \[position\] column: expected list of length >= 1; found"):
        parse_preset("[position]\ncolumn = []\n", "p")


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
