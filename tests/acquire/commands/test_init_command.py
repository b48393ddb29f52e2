"""exidyn init: files that it writes, reads back as proposed, and does not write over."""

import json
import re

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.identify.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identify.recordings.recording import Recording, Signal
from exidyn.identify.robot_files.robot_file import read_model, urdf_text

from ...parts.runs.logs import cobot_log, columns

LOG = cobot_log()


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.urdf").write_text(urdf_text(LOG.model))
    named = {"Zeit": 1e3 * LOG.time, **columns("A{k}_Winkel", np.degrees(LOG.position))}
    named |= columns("A{k}_Strom", LOG.current)
    rows = np.column_stack(list(named.values()))
    np.savetxt("log.csv", rows, delimiter=",", header=",".join(named), comments="", fmt="%.9g")
    return tmp_path


def test_what_init_writes_imports_the_log_in_si(files, capsys):
    assert main(["init", "log.csv", "--urdf", "arm.urdf", "--json", "found.json"]) == 0
    assert re.search(r"^unit of position +deg +> 99\.9 %", capsys.readouterr().out, re.MULTILINE)
    found = json.loads((files / "found.json").read_text())
    assert found["then"] == "exidyn import log.csv --robot robot.toml"
    assert main(found["then"].split()[1:]) == 0
    run = read_recording(files / "log.mcap")
    np.testing.assert_allclose(run.signals["position"].values, LOG.position, atol=1e-6)
    np.testing.assert_allclose(run.signals["current"].values, LOG.current, atol=1e-6)
    assert run.signals["position"].time[-1] == pytest.approx(LOG.time[-1])


def test_gains_that_are_not_all_told_are_a_comment(files):
    assert main(["init", "log.csv", "--urdf", "arm.urdf"]) == 0
    text = (files / "robot.toml").read_text()
    assert "# Gains of the log [N m per unit]: [" in text
    assert "?" in text
    assert "\n[drive]" not in text
    assert np.all(read_model(files / "robot.toml").robot.drive_gain == 1.0)


@pytest.mark.parametrize("existing", ["robot.toml", "preset.toml"])
def test_no_file_is_written_over_without_force(files, existing, capsys):
    (files / existing).write_text("mine")
    assert main(["init", "log.csv", "--urdf", "arm.urdf"]) == REFUSED
    assert f"{existing}: this file exists; --force" in capsys.readouterr().err
    assert (files / existing).read_text() == "mine"
    other = {"robot.toml": "preset.toml", "preset.toml": "robot.toml"}[existing]
    assert not (files / other).exists()
    assert main(["init", "log.csv", "--urdf", "arm.urdf", "--force"]) == 0
    assert (files / existing).read_text() != "mine"


def test_a_recording_needs_no_preset_and_efforts_in_amperes_an_option(files):
    signals = {"position": LOG.position, "torque": LOG.current / 50.0}
    run = Recording("run", LOG.model, {name: Signal(LOG.time, one) for name, one in signals.items()})
    write_recording(run, files / "run.mcap")
    assert main(["init", "run.mcap", "--urdf", "arm.urdf", "--json", "found.json"]) == 0
    assert not (files / "preset.toml").exists()
    assert json.loads((files / "found.json").read_text())["then"].endswith("--effort current")


def test_what_is_undecided_is_said_and_no_preset_is_written(files, capsys):
    noise = np.random.default_rng(0).normal(size=LOG.position.shape)
    names = ["t", *columns("q{k}", noise), *columns("i{k}", noise)]
    rows = np.column_stack([LOG.time, 1.5 * LOG.position, noise])
    np.savetxt("far.csv", rows, delimiter=",", header=",".join(names), comments="")
    assert main(["init", "far.csv", "--urdf", "arm.urdf"]) == 0
    said = capsys.readouterr()
    assert "NOT DECIDED: unit of position" in said.out
    assert "Next:" not in said.out
    assert not (files / "preset.toml").exists()
    assert "# unit of position" in (files / "robot.toml").read_text()
