"""The files that stand in for a person's own: each is read by the command that README gives it to."""

import numpy as np
import pytest

from exidyn.acquire.command_line import main
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.robot_files.robot_file import read_model

pytestmark = pytest.mark.clocked(patient=True)


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


def test_files_of_ones_own_are_not_written_over(tmp_path, capsys):
    (tmp_path / "run.mcap").write_text("")
    assert main(["example", "files", "--output", str(tmp_path)]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"robot.toml", "log.csv", "truth.toml", "run.mcap"}
    (tmp_path / "log.csv").write_text("my own")
    assert main(["example", "files", "--output", str(tmp_path)]) == 2
    assert (tmp_path / "log.csv").read_text() == "my own"
    assert "is not overwritten" in capsys.readouterr().err
