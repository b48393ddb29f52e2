"""exidyn example: what it prints, writes and does not overwrite; its first example in full takes minutes."""

import json
import shlex
from pathlib import Path

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.acquire.commands import command
from exidyn.acquire.commands.example_command import NAMED
from exidyn.acquire.examples.example_runs import FILES, comparison
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.robot_files.robot_file import read_model

from ...parts.small import small_fit, two_joint_files

pytestmark = pytest.mark.clocked(patient=True)


@pytest.mark.long
def test_the_first_example_finds_the_truth(tmp_path, capsys):
    assert main(["example", "--length", "30", "--output", str(tmp_path)]) == 0
    printed, progress = capsys.readouterr()
    assert f"exidyn identify {tmp_path}/unloaded.mcap --payload {tmp_path}/loaded.mcap --mass 175" in progress
    lines = [line.split() for line in printed.partition("Identified and true values")[2].splitlines() if line]
    gains = [line for line in lines if line[0] == "drive"]
    assert len(gains) == 6
    assert all(abs(float(line[-3])) < 3.0 for line in gains)  # % of truth; nominal is 10 % wrong
    assert all(abs(float(line[-1])) < 4.0 for line in gains)  # standard deviations: one draw in a thousand
    spring = [line for line in lines if line[0] == "spring"]
    assert len(spring) == 2
    assert all(abs(float(line[-1])) < 3 for line in spring)  # deviations


def test_identified_gains_stand_beside_the_true_ones():
    """The nominal ones of the small arm are 10 % too large."""
    fit = small_fit.fit()
    rows = [line.split() for line in comparison(fit, two_joint_files.PLANT).splitlines()]
    gains = [row for row in rows if row[:1] == ["drive"]]
    for joint, row in zip(("shoulder", "elbow"), gains, strict=True):
        assert row[:4] == ["drive", "gain", joint, "N"]
        true, nominal, identified = map(float, row[5:8])
        assert nominal / true == pytest.approx(1.1, rel=1e-3)
        assert identified / true == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("name", ["gains", "real"])
def test_commands_are_printed_as_they_would_be_run(name, tmp_path, capsys):
    folder = tmp_path / "with space"
    assert main(["example", name, "--commands", "--output", str(folder)]) == 0
    lines = [shlex.split(line) for line in capsys.readouterr().out.splitlines()]
    expected = NAMED[name].steps(folder, NAMED[name].length, None)
    assert lines == [["exidyn", step.command, *step.arguments] for step in expected]
    for step in expected:
        command(step.command).parser().parse_args(step.arguments)
    written = {path.name for path in folder.iterdir()}
    assert written == ({"robot.toml", "truth.toml", "truth-loaded.toml"} if name == "gains" else set(FILES))


@pytest.mark.slow
def test_a_real_arm_lacks_the_spring_that_its_maker_documents(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["example", "real"]) == 0
    assert "gas counterbalance on joint 2" in capsys.readouterr().out
    found = json.loads(Path("exidyn-example-real/exidyn-diagnosis/diagnosis.json").read_text())
    [spring] = [each for each in found["undecided"] if each["effect"] == "joint_spring"]
    assert spring["joints"] == [2]
    assert spring["family_probability"] > 0.99
    assert spring["alternatives"][0]["effect"] == "spring_balancer"
    before, after = (found[f"torque_rms_{when}"][1] for when in ("before", "after"))
    assert after < 0.2 * before


def test_robot_and_log_are_what_the_commands_take(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["example", "files", "--output", "."]) == 0
    assert "log.csv" in capsys.readouterr().out
    assert main(["import", "log.csv", "--robot", "robot.toml", "--degrees"]) == 0
    log = read_recording("log.mcap")
    limits = log.robot.limits
    position = log.signals["position"].values
    assert np.all((position >= limits.position_lower) & (position <= limits.position_upper))
    stated, true = (read_model(name).robot.drive_gain for name in ("robot.toml", "truth.toml"))
    assert np.all(stated != true)


@pytest.mark.parametrize(("name", "file"), [("files", "log.csv"), ("servos", "arm.xml"), ("gains", "a.mcap")])
def test_files_of_ones_own_are_not_written_over(name, file, tmp_path, capsys):
    (tmp_path / file).write_text("my own")
    assert main(["example", name, "--output", str(tmp_path)]) == REFUSED
    assert [path.name for path in tmp_path.iterdir()] == [file]
    assert (tmp_path / file).read_text() == "my own"
    assert "is not overwritten" in capsys.readouterr().err
