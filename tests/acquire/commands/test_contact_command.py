"""exidyn contact: what it prints, writes and refuses."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.identification.fit.fit_file import write_fit

from ...parts.small import small_fit, two_joint_files


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """fit.json, runs, and loaded.mcap, which does not state its payload of 3 kg."""
    folder = tmp_path_factory.mktemp("contact")
    write_fit(small_fit.fit(), folder / "fit.json")
    runs = [two_joint_files.run(f"free{k}", 3 + k, 9 + k) for k in range(2)]
    two_joint_files.write(folder, *runs, two_joint_files.run("empty"), two_joint_files.loaded())
    return folder


@pytest.fixture
def folder(files, tmp_path, monkeypatch):
    """The working folder, with links to the files."""
    for file in files.iterdir():
        (tmp_path / file.name).symlink_to(file)
    monkeypatch.chdir(tmp_path)
    return tmp_path


FREE = ["--free", "free0.mcap", "free1.mcap"]


def test_an_unstated_payload_is_a_contact(folder, capsys):
    outputs = ["-o", "out.csv", "--json", "out.json"]
    assert main(["contact", "loaded.mcap", "--fit", "fit.json", *FREE, *outputs]) == 0
    printed, notes = capsys.readouterr()
    assert "loaded: " in printed
    assert "The threshold for 1 false alarm an hour" in " ".join(printed.split())
    assert "0.7 min without contact. Longer runs without contact lower it." in " ".join(printed.split())
    assert "Mean force on the flange" in printed
    assert "written: out.csv" in notes
    result = json.loads((folder / "out.json").read_text())
    assert result["alarms"]
    assert result["alarms"][0]["over_threshold"] > 1.0
    table = np.genfromtxt(folder / "out.csv", delimiter=",", names=True)
    assert table.dtype.names[:5] == ("t", "external1", "external2", "contact_from1", "contact_from2")
    assert np.nanmax(np.abs(table["external1"]) / table["contact_from1"]) > 1.0


def test_the_payload_that_the_fit_has_is_none(folder, capsys):
    assert main(["contact", "loaded.mcap", "--fit", "fit.json", "--payload", "L", *FREE, "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["alarms"] == []


def test_without_drive_gains_there_is_no_force(folder, capsys):
    """Torques are in amperes; newtons would be untrue."""
    fit = small_fit.plain_fit()
    robot = replace(fit.model.robot, drive_gain=np.ones(2))
    write_fit(replace(fit, model=replace(fit.model, robot=robot)), Path("bare.json"))
    assert main(["contact", "loaded.mcap", "--fit", "bare.json", *FREE, "--json", "out.json"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "torque [A]" in printed
    assert "No force in newtons: drive gains are unknown" in printed
    result = json.loads((folder / "out.json").read_text())
    assert result["force_mean"] == result["alarms"][0]["force"] == [None] * 3


def test_without_a_threshold_the_torques_are_printed(folder, capsys):
    assert main(["contact", "free0.mcap", "--fit", "fit.json"]) == 0
    printed, notes = capsys.readouterr()
    assert "written" not in notes
    assert "no threshold, so contacts are not counted: state runs" in printed
    assert "shoulder" in printed


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--payload", "X"], "no payload 'X'. Payloads of the fit: L"),
        (["--free", "empty.mcap"], "empty was used for the fit"),
        (["-o", "out.txt"], "--output out.txt: the name must end in .csv"),
        (["--free", "loaded.mcap"], "loaded.mcap is given with --free too"),
    ],
)
def test_bad_input_gets_one_clear_error(folder, arguments, message, capsys):
    assert main(["contact", "loaded.mcap", "--fit", "fit.json", *arguments]) == REFUSED
    assert message in capsys.readouterr().err
