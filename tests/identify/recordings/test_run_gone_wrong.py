"""The recording of a run that went wrong is opened, whatever is in it; a table with the same is refused."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.identification.errors import BadTime, BadUnit, NotFinite
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.recording import Signal
from exidyn.identification.recordings.recording_checks import check
from exidyn.identification.robot_files.robot_file import model_text

from ...parts.runs.runs import require
from ...parts.small.two_joint_files import run, write

RUN = run("run")


def ran_away(away=50.0):
    """The elbow, in the last twentieth of the run, as far as `away` [rad]."""
    position = RUN.signals["position"]
    values = position.values.copy()
    last = len(values) // 20
    values[-last:, 1] += np.linspace(0.0, away, last)
    return of_position(position.time, values)


def of_position(time, values):
    return replace(RUN, signals={**RUN.signals, "position": Signal(time, values)})


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def words(text):
    return " ".join(text.split())


def test_a_joint_that_ran_away_is_printed_and_warned_of(folder, capsys):
    [path] = write(folder, ran_away())
    assert main(["identify", path]) == 0
    assert "run: elbow is at" in words(capsys.readouterr().out)
    assert main(["info", path]) == 0
    printed = capsys.readouterr().out
    assert "warning: elbow is at 49." in words(printed) or "warning: elbow is at 50" in words(printed)
    assert "which it cannot reach" in words(printed)
    assert "degrees" not in printed


def test_the_warning_stays_with_the_recording(folder):
    write_recording(ran_away(), folder / "run.mcap")
    found = read_recording(folder / "run.mcap")
    write_recording(found, folder / "again.mcap")
    again = read_recording(folder / "again.mcap")
    assert again.warnings == found.warnings
    assert sum("which it cannot reach" in warning for warning in again.warnings) == 1


def test_the_same_in_a_table_is_refused(folder, capsys):
    signals = ran_away().signals
    columns = signals["position"].time, signals["position"].values, signals["current"].values
    header = "t,q1,q2,i1,i2"
    np.savetxt(folder / "run.csv", np.column_stack(columns), "%.9g", ",", header=header, comments="")
    (folder / "robot.toml").write_text(model_text(RUN.model))
    assert main(["import", "run.csv", "--robot", "robot.toml"]) == REFUSED
    assert "looks like degrees" in capsys.readouterr().err


def broken(change):
    """The run with its positions changed."""
    position = RUN.signals["position"]
    time, values = position.time.copy(), position.values.copy()
    change(time, values)
    return of_position(time, values)


def infinite(time, values):
    values[-1, 1] = np.inf


def twice(time, values):
    time[3000:] -= 0.004


def back(time, values):
    time[3000:] -= 0.5


def thousandfold(time, values):
    time *= 1000.0


def fast(time, values):
    values[:, 0] *= 60.0


@pytest.mark.parametrize(
    ("change", "error", "warning"),
    [
        (infinite, NotFinite, "position of elbow is not finite in 1 of 5000 samples"),
        (twice, BadTime, "time of position does not increase at 1 of 4999 steps"),
        (thousandfold, BadUnit, "position comes every 4 s"),
        (fast, BadUnit, "shoulder turns at"),
    ],
    ids=["infinite", "twice", "milliseconds", "fast"],
)
def test_what_cannot_be_is_a_warning_in_a_recording_and_an_error_elsewhere(folder, change, error, warning):
    wrong = broken(change)
    with pytest.raises(error):
        check(wrong)
    write_recording(wrong, folder / "run.mcap")
    found = read_recording(folder / "run.mcap")
    assert any(text.startswith(warning) for text in found.warnings)
    require(found, position=wrong.signals["position"].values)


@pytest.mark.parametrize(("change", "left"), [(infinite, 4999), (twice, 4999), (back, 4875)])
def test_identification_leaves_out_samples_it_cannot_use(change, left):
    found = check(replace(broken(change), recorded=True))
    position = found.signals["position"]
    assert len(position) == left
    assert np.isfinite(position.values).all()
    assert (np.diff(position.time) > 0).all()
    assert any(f"position: {5000 - left} of 5000 samples" in warning for warning in found.warnings)


@pytest.mark.parametrize("command", ["info", "identify"])
def test_an_unfinished_file_is_recovered_first(folder, command, capsys):
    [path] = write(folder, RUN)
    (folder / "run.mcap").rename("run.mcap.part")
    assert main([command, "run.mcap.part"]) == REFUSED
    [line] = capsys.readouterr().err.splitlines()[-1:]
    assert line.endswith("exidyn info --repair run.mcap.part")
    assert main(["info", "--repair", "run.mcap.part"]) == 0
