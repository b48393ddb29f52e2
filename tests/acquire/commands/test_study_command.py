"""`exidyn study`: what it refuses, and a study on the mock that is stopped in every way and goes on."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from exidyn.acquire.arguments.exit_codes import INTERRUPTED, REFUSED, STOPPED, UNSAFE
from exidyn.acquire.command_line import main
from exidyn.acquire.study.rounds import rounds
from exidyn.identification.effects import JointSpring, Prior
from exidyn.identification.robot_files.robot_text import model_text

from ...parts.small import small_diagnosis, two_joints


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An arm as stated, and as it is: with a spring at its elbow."""
    monkeypatch.chdir(tmp_path)
    nominal = small_diagnosis.nominal_model()
    (tmp_path / "robot.toml").write_text(model_text(nominal))
    true = two_joints.model(JointSpring(("elbow",)))
    values = small_diagnosis.TRUE | {"Ks2": small_diagnosis.STIFFNESS}
    stated = {n: Prior(values.get(n, v)) for n, v in zip(true.names, true.nominal_values, strict=True)}
    robot = replace(true.robot, gear_ratio=small_diagnosis.GEARS)
    (tmp_path / "truth.toml").write_text(model_text(replace(true, robot=robot, stated=stated)))
    return tmp_path


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--from", "nowhere"], "no recordings there"),
        (["--from", ".", "--plant", "truth.toml"], "omit one of them"),
        (["--driver", "kuka_rsi", "--plant", "truth.toml"], "kuka_rsi moves a real arm"),
        (["--com", "0", "0", "1"], "com given without --mass"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_made(folder, more, words, capsys):
    assert main(["study", "robot.toml", *more]) == REFUSED
    assert words in capsys.readouterr().err
    assert rounds(folder / "exidyn-study") == []


def begun(folder: Path, *more: str) -> subprocess.Popen:
    words = ["study", "robot.toml", "--plant", "truth.toml", "--length", "10", "--search", "1"]
    words += ["--minutes", "1.2", *more]
    return subprocess.Popen(
        [sys.executable, "-m", "exidyn.acquire.command_line", *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def when(there, process: subprocess.Popen, seconds: float = 600.0) -> None:
    """Wait until something is there."""
    end = time.monotonic() + seconds
    while not there():
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.mark.slow
def test_an_arm_that_cannot_be_stopped_is_told_of_by_the_notebook_too(folder):
    study = begun(folder, "--set", "faults=runaway elbow 2 at 1; deaf at start; stop fails 3 at start")
    _, words = study.communicate(timeout=600)
    assert study.returncode == UNSAFE, words
    assert "elbow STILL MOVES at 2 rad/s" in words.splitlines()[-1]
    assert "PRESS THE EMERGENCY STOP" in (folder / "exidyn-study" / "notebook.html").read_text()


@pytest.mark.clocked
@pytest.mark.slow
@pytest.mark.long
def test_a_study_that_is_faulted_interrupted_and_killed_goes_on_with_nothing_repeated(folder):
    first = folder / "exidyn-study" / "round-01"
    faulted = begun(folder, "--set", "faults=drop at 2 for 0.5")
    _, words = faulted.communicate(timeout=600)
    assert faulted.returncode == STOPPED, words
    assert "was stopped before its end" in words
    assert not (first / "run.mcap").exists()
    planned = (first / "plan.toml").read_bytes()

    interrupted = begun(folder)
    when((first / "diagnosis.part").is_dir, interrupted)
    interrupted.send_signal(signal.SIGINT)
    interrupted.communicate(timeout=600)
    assert interrupted.returncode == INTERRUPTED
    assert (first / "plan.toml").read_bytes() == planned
    assert not (first / "diagnosis").exists()
    kept = {path: path.read_bytes() for path in (first / "run.mcap", first / "fit" / "fit.json")}

    killed = begun(folder)
    second = folder / "exidyn-study" / "round-02"
    when(lambda: list(second.glob("attempt-*.mcap.part")), killed)
    killed.send_signal(signal.SIGKILL)
    killed.communicate(timeout=600)
    assert not (second / "run.mcap").exists()
    kept[second / "plan.toml"] = (second / "plan.toml").read_bytes()
    kept[first / "diagnosis" / "choice.json"] = (first / "diagnosis" / "choice.json").read_bytes()

    last = begun(folder, "--json", "study.json")
    _, words = last.communicate(timeout=1800)
    assert last.returncode == 0, words
    assert all(path.read_bytes() == content for path, content in kept.items())
    choice = json.loads((folder / "study.json").read_text())
    assert choice["verdict"] in ("decided", "undecidable", "out of time")
    assert any(2 in joints for _, joints in choice["believed_findings"])
    assert not any(1 in joints for _, joints in choice["believed_findings"])
    assert all(one in choice["believed_findings"] for one in choice["findings"])
