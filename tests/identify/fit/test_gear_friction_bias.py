"""The bias of a fit that lacks friction under load is what the fit says it would be."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects.load_dependent_friction import LoadDependentFriction
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit, write_fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import Sensors, simulate
from exidyn.trajectories.random_motion import random_fourier

UNDER_LOAD = np.array([0.04, 0.03, 0.05, 0.02, 0.03, 0.04])
"""Friction over transmitted torque of each joint."""


def run(under_load: np.ndarray = UNDER_LOAD) -> Recording:
    """A run of the cobot with friction under load."""
    nominal = read_model("cobot")
    plant = nominal + LoadDependentFriction()
    plant = plant.at(np.concatenate([nominal.nominal_values, under_load]))
    motion = random_fourier(nominal.robot.limits, 14.0, seed=1).at(np.arange(1400) / 100.0)
    gain = nominal.robot.drive_gain
    return simulate(plant, plant.nominal_values, gain, motion, nominal, Sensors(0.005))


def with_torque(recording: Recording) -> Recording:
    """The run of an arm with torque sensors."""
    current = recording.signals["current"]
    others = {name: signal for name, signal in recording.signals.items() if name != "current"}
    torque = Signal(current.time, current.values * recording.model.robot.drive_gain)
    return replace(recording, signals={**others, "torque": torque})


@pytest.fixture(scope="module")
def fit() -> Fit:
    return identify([with_torque(run())], as_recorded=True, drop=False)


def test_the_bias_is_the_change_that_the_friction_causes(fit: Fit) -> None:
    without = identify([with_torque(run(np.zeros(6)))], as_recorded=True, drop=False)
    assert fit.gear_friction_bias is not None
    change = (fit.estimate.values - without.estimate.values) / without.estimate.std
    predicted = fit.gear_friction_bias @ UNDER_LOAD / without.estimate.std
    assert np.linalg.norm(change) > 10.0
    assert np.linalg.norm(change - predicted) < 0.3 * np.linalg.norm(change)


def test_a_file_keeps_the_bias(fit: Fit, tmp_path) -> None:
    write_fit(fit, tmp_path / "fit.json")
    np.testing.assert_allclose(read_fit(tmp_path / "fit.json").gear_friction_bias, fit.gear_friction_bias)


def test_a_fit_of_currents_states_none() -> None:
    assert identify([run()], as_recorded=True).gear_friction_bias is None
