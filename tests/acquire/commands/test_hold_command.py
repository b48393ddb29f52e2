"""exidyn hold on the mock: drift by a right and a wrong fit, and what it takes to guide the arm."""

import json
from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.command_line import main
from exidyn.acquire.commands import hold_command
from exidyn.acquire.run.arms import standing_arm
from exidyn.drivers.mock.driver import Mock
from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.fit.fit_file import read_fit, write_fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.robot_files.commented import commented_text
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import Sensors, simulate
from exidyn.trajectories.random_motion import random_fourier

pytestmark = pytest.mark.slow

PUSH = 15.0
"""Torque of the person on the first joint [N m], above its friction."""


@pytest.fixture(scope="module")
def fit(tmp_path_factory):
    """Path of a fit of the cobot."""
    model = read_model("cobot")
    motion = random_fourier(model.robot.limits, 14.0, seed=1).at(np.arange(1400) / 100.0)
    run = simulate(model, model.nominal_values, model.robot.drive_gain, motion, model, Sensors(0.005))
    path = tmp_path_factory.mktemp("fit") / "fit.json"
    write_fit(identify([run], as_recorded=True), path)
    return path


def held(fit, folder, *options):
    """Exit code, and the result as JSON."""
    file, run = folder / "hold.json", folder / "hold.mcap"
    arguments = ["hold", str(fit), "--seconds", "1.5", "--output", str(run), "--json", str(file)]
    code = main([*arguments, *options])
    return code, json.loads(file.read_text())


def test_an_arm_floats_by_the_torque_of_its_fit(fit, tmp_path, capsys):
    code, result = held(fit, tmp_path)
    assert code == 0
    assert max(result["drift"]) < 1e-3
    text = " ".join(capsys.readouterr().err.split())
    assert "floats for 1.5 s by the torque of" in text
    assert "stopped at 5 degrees from the start or 20 % of its velocity limits" in text
    assert main(["info", str(tmp_path / "hold.mcap")]) == 0
    assert "command_torque" in capsys.readouterr().out


def test_a_body_that_the_fit_lacks_makes_it_drift_and_it_is_stopped(fit, tmp_path):
    model = read_model("cobot")
    plant = tmp_path / "loaded.toml"
    plant.write_text(
        commented_text(model + Payload("L", known_parameters(8.0, (0.0, 0.0, 0.2), (0.1, 0, 0, 0.1, 0, 0.1))))
    )
    code, result = held(fit, tmp_path, "--plant", str(plant), "--drift", "2")
    assert code == 1
    assert "drift" in result["stop"]
    assert np.radians(2.0) < max(result["drift"]) < np.radians(6.0)


def test_the_torque_that_guides_the_arm_is_measured(fit, tmp_path, monkeypatch):
    gain = read_model("cobot").robot.drive_gain[0]

    def pushed_arm(*arguments):
        plant = standing_arm(*arguments)()
        push, measure, count = plant.push, plant.measure, [0]

        def person():
            return PUSH * (count[0] > 100)  # from 0.2 s on

        def pushed(torque, seconds):
            count[0] += 1
            push(torque + person() * np.eye(6)[0], seconds)

        def measured():  # the motors do not make the person's torque
            values = measure()
            return values._replace(current=values.current - person() / gain * np.eye(6)[0])

        plant.push, plant.measure = pushed, measured
        return lambda: plant

    monkeypatch.setattr(hold_command, "standing_arm", pushed_arm)
    monkeypatch.setattr(hold_command, "SPEED", 1.0)
    code, result = held(fit, tmp_path, "--guide")
    assert code == 0
    assert result["drift"][0] > 0.05
    assert result["torque_to_move_it"][0] == pytest.approx(PUSH, rel=0.15)
    assert result["torque_to_move_it"][1:] == [None] * 5


def test_a_fit_without_gains_is_refused(fit, tmp_path, capsys):
    before = read_fit(fit)
    robot = replace(before.model.robot, drive_gain=np.ones(6))
    size, n = len(before.estimate.covariance), robot.dof
    known = np.outer(*2 * [np.arange(size) < size - n])
    estimate = replace(before.estimate, gain=np.ones(n), covariance=known * before.estimate.covariance)
    write_fit(
        replace(before, model=replace(before.model, robot=robot), estimate=estimate), tmp_path / "fit.json"
    )
    assert main(["hold", str(tmp_path / "fit.json"), "--output", str(tmp_path / "x.mcap")]) == 2
    assert "cobot: drive gains are unknown" in " ".join(capsys.readouterr().err.split())


def test_a_controller_without_torque_is_refused_before_its_drives_are_powered(
    fit, tmp_path, monkeypatch, capsys
):
    opened = Mock.open
    monkeypatch.setattr(Mock, "open", lambda self: replace(opened(self), takes_torque=False))
    monkeypatch.setattr(Mock, "arm_drives", lambda self: pytest.fail("powered"))
    assert main(["hold", str(fit), "--output", str(tmp_path / "x.mcap")]) == 2
    assert "this controller takes no torque" in " ".join(capsys.readouterr().err.split())
