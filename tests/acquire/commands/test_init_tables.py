"""exidyn init: tables and arrays as people have them are proposed as import reads them."""

import json
import re
import shlex

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.robot_files.robot_file import read_model, urdf_text

from ...parts.runs.logs import cobot_log, columns

LOG = cobot_log()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.urdf").write_text(urdf_text(LOG.model))
    return tmp_path


def write(path, named, above=(), separator=","):
    rows = np.column_stack(list(named.values())).tolist()
    lines = [separator.join(f"{value:.9g}" for value in row) for row in rows]
    if separator == ";":
        lines = [line.replace(".", ",") for line in lines]
    path.write_text("\n".join([separator.join(named), *above, *lines]))


def imported(log, capsys, *options):
    """The run, imported as init proposes, and what init printed."""
    assert main(["init", log, "--robot", "arm.urdf", "--json", "found.json", *options]) == 0
    said = capsys.readouterr().out
    with open("found.json") as file:
        found = json.load(file)
    assert not found["refusal"]
    assert main(shlex.split(found["then"])[1:]) == 0
    return read_recording(re.sub(r"\..*", ".mcap", log)), said


def require_si(run, rows=slice(None)):
    np.testing.assert_allclose(run.signals["position"].values, LOG.position[rows], atol=1e-6)
    np.testing.assert_allclose(run.signals["current"].values, LOG.current[rows], atol=1e-6)


def test_a_row_of_units_and_decimal_commas(folder, capsys):
    named = {"Time": 1e3 * LOG.time, **columns("J{k} Position", np.degrees(LOG.position))}
    named |= columns("J{k} Current", 1e3 * LOG.current)
    write(folder / "log.csv", named, [";".join(["ms", *6 * ["deg"], *6 * ["mA"]])], ";")
    run, _ = imported("log.csv", capsys)
    require_si(run)
    assert run.signals["position"].time[-1] == pytest.approx(LOG.time[-1])
    decided = np.array([gain["known"] for gain in json.loads((folder / "found.json").read_text())["gains"]])
    stated = read_model(folder / "robot.toml").robot.drive_gain
    true = LOG.model.robot.drive_gain
    assert np.all(np.abs(np.log(stated[decided] / true[decided])) < 0.7)  # N m/A, not N m/mA


def test_torques_of_another_unit_that_are_no_torques_of_joints_keep_their_gains(folder, capsys):
    named = {"t": LOG.time, **columns("q{k}", LOG.position), **columns("tau{k} [mNm]", 1e3 * LOG.current)}
    write(folder / "log.csv", named)
    run, _ = imported("log.csv", capsys)
    found = json.loads((folder / "found.json").read_text())
    stated = read_model(folder / "robot.toml").robot.drive_gain
    decided = np.array([gain["known"] for gain in found["gains"]])
    torque = run.signals["current"].values * stated
    true = LOG.current * LOG.model.robot.drive_gain
    ratio = np.abs(torque[:, decided]).mean(axis=0) / np.abs(true[:, decided]).mean(axis=0)
    assert np.all(np.abs(np.log(ratio)) < 0.7)


def test_missing_numbers_and_rows(folder, capsys):
    named = {"t": LOG.time, **columns("q{k}", LOG.position), **columns("i{k}", LOG.current)}
    named["i3"] = np.where((LOG.time > 2) & (LOG.time < 2.05), np.nan, named["i3"])
    empty = np.arange(len(LOG.time)) == 700
    named = {
        name: column if name == "t" else np.where(empty, np.nan, column) for name, column in named.items()
    }
    write(folder / "log.csv", named)
    run, _ = imported("log.csv", capsys)
    lost = np.flatnonzero(np.isnan(named["i3"]))
    np.testing.assert_allclose(run.signals["current"].values, np.delete(LOG.current, lost, axis=0), atol=1e-6)
    assert f"these {len(lost) - 1} rows are left out" in " ".join(run.warnings)


def test_columns_may_be_named(folder, capsys):
    named = {
        "a": 1e3 * LOG.time,
        **columns("x{k}", np.degrees(LOG.position)),
        **columns("q{k}", LOG.velocity),
    }
    named |= columns("i{k}", LOG.current)
    write(folder / "log.csv", named)
    run, said = imported("log.csv", capsys, "--columns", "time=a", "position=x1..6", "velocity=q{number}")
    require_si(run)
    assert "order of joints" not in said
    np.testing.assert_allclose(run.signals["velocity"].values, LOG.velocity, atol=1e-6)
    assert (
        main(["init", "log.csv", "--robot", "arm.urdf", "--force", "--columns", "position=y1..6"]) == REFUSED
    )
    assert "no column y1, y2" in capsys.readouterr().err


def test_a_gripper_behind_the_joints_is_left_out(folder, capsys):
    share = 0.5 + 0.5 * np.sin(LOG.time)[:, None]
    arrays = {"obs/qpos": np.hstack([LOG.position, share]), "obs/effort": np.hstack([LOG.torque, share])}
    np.savez("episode.npz", **arrays)
    run, said = imported("episode.npz", capsys, "--rate", "100")
    np.testing.assert_allclose(run.signals["position"].values, LOG.position, atol=1e-9)
    np.testing.assert_allclose(run.signals["torque"].values, LOG.torque, atol=1e-9)
    assert "obs/qpos7 stays between 0 and full scale like a gripper" in " ".join(said.split())


def test_of_two_arms_one_is_named(folder, capsys):
    share = 0.5 + 0.5 * np.sin(LOG.time)[:, None]
    other = LOG.position[::-1]
    arrays = {"obs/qpos": np.hstack([other, share, LOG.position, share])}
    arrays["obs/effort"] = np.hstack([LOG.torque[::-1], share, LOG.torque, share])
    np.savez("episode.npz", **arrays)
    question = (
        "obs/qpos has 14 columns for 6 joints (joint1 to joint6): which? For example 1 to 6, or 8 to 13"
    )
    assert main(["init", "episode.npz", "--robot", "arm.urdf", "--rate", "100"]) == REFUSED
    assert question in capsys.readouterr().err
    run, _ = imported("episode.npz", capsys, "--rate", "100", "--columns", "position=obs/qpos8..13")
    np.testing.assert_allclose(run.signals["position"].values, LOG.position, atol=1e-9)
    np.testing.assert_allclose(run.signals["torque"].values, LOG.torque, atol=1e-9)


def test_a_rate_is_refused_where_the_log_has_time(folder, capsys):
    write(
        folder / "log.csv",
        {"Time": LOG.time, **columns("q{k}", LOG.position), **columns("i{k}", LOG.current)},
    )
    assert main(["init", "log.csv", "--robot", "arm.urdf", "--rate", "100"]) == REFUSED
    assert "log.csv has its own time, column Time; --rate" in capsys.readouterr().err
    assert main(["import", "log.csv", "--robot", "arm.urdf", "--rate", "100"]) == REFUSED
    assert "log.csv has its own time, column Time; --rate" in capsys.readouterr().err


def test_what_import_refuses_is_said_in_place_of_the_next_command(folder, capsys):
    named = {"t": LOG.time.copy(), **columns("q{k}", LOG.position), **columns("i{k}", LOG.current)}
    write(folder / "log.csv", named)
    lines = (folder / "log.csv").read_text().split("\n")
    lines[40] = lines[40].rpartition(",")[0] + ",overload"
    (folder / "log.csv").write_text("\n".join(lines))
    assert main(["init", "log.csv", "--robot", "arm.urdf", "--json", "found.json"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "import refuses the log: log.csv line 41: 'overload' in column 'i6' is not a number" in said
    assert "correct the cell, or empty it if nothing was measured" in said
    assert "Next:" not in said
    assert main(["import", "log.csv", "--robot", "robot.toml"]) == REFUSED
