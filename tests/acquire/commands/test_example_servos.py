"""The files of an arm of servos: from commands and positions alone its servos and its friction are found."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.command_line import main
from exidyn.acquire.examples.example_files import CENTER, MASS, TERMS
from exidyn.identification.effects import known_parameters
from exidyn.identification.fit.identification import identify
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.plant import typical_plant
from exidyn.identification.simulation.simulate import follow
from exidyn.trajectories.random_motion import random_fourier

pytest.importorskip("mujoco")

TICK = 0.01


def recorded(name, payload=None):
    """A run of the true arm without current, written and read back."""
    nominal, truth = read_model("robot.toml"), read_model("truth-loaded.toml")
    motion = random_fourier(nominal.robot.limits, 12.0, seed=2).at(np.arange(0.0, 12.0, TICK))
    plant = typical_plant(truth, motion.position[0], payload=payload.name if payload else "")
    signals = follow(plant, motion.position, motion.velocity, TICK)
    silent = replace(signals["current"], values=np.full_like(signals["current"].values, np.nan))
    write_recording(Recording(name, nominal, signals | {"current": silent}, payload), f"{name}.mcap")
    return read_recording(f"{name}.mcap")


@pytest.mark.slow
def test_commands_and_positions_tell_the_servos_and_the_friction(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["example", "servos", "--output", "."]) == 0
    assert "arm.xml" in capsys.readouterr().out
    body = KnownPayload("L", known_parameters(MASS, CENTER))
    fit = identify([recorded("run"), recorded("loaded", body)])
    truth = read_model("truth.toml")
    np.testing.assert_allclose(fit.estimate.gain, truth.robot.drive_gain, rtol=0.1)
    names = dict(zip(fit.names, fit.estimate.values, strict=True))
    drag = [names[f"Fv{joint}"] for joint in range(1, 6)]
    np.testing.assert_allclose(drag, TERMS["Fv"], rtol=0.15)


def test_the_file_is_not_the_arm(tmp_path):
    assert main(["example", "servos", "--output", str(tmp_path)]) == 0
    nominal, truth = (read_model(tmp_path / name) for name in ("robot.toml", "truth.toml"))
    assert nominal.robot.joints == truth.robot.joints
    assert nominal.robot.servo is not None
    assert truth.robot.servo is not None
    assert nominal.stated["Ia1"].value == 0.1
    assert truth.stated["Ia1"].value < 0.05
