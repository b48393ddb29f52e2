"""Files of exidyn that were edited by hand and once ended in a Traceback: one line, and exit code 2."""

import os
import re
import shutil
from pathlib import Path

import pytest

from exidyn.acquire.command_line import main
from exidyn.identification.errors import RobotError
from exidyn.identification.recordings.tables.preset import parse_preset

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
