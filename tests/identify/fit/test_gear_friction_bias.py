"""The bias of a fit that lacks friction under load is what the fit says it would be."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.effects.load_dependent_friction import LoadDependentFriction
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit, write_fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import Sensors, simulate
from exidyn.trajectories.random_motion import random_fourier

UNDER_LOAD = np.array([0.04, 0.03, 0.05, 0.02, 0.03, 0.04])
"""Friction over transmitted torque of each joint."""


def run(under_load: np.ndarray = UNDER_LOAD, payload: KnownPayload | None = None) -> Recording:
    """A run of the cobot with friction under load, empty or with a payload."""
    nominal = read_model("cobot")
    arm = nominal if payload is None else nominal + Payload(payload.name, payload.known)
    plant = arm + LoadDependentFriction()
    plant = plant.at(np.concatenate([arm.nominal_values, under_load]))
    motion = random_fourier(nominal.robot.limits, 14.0, seed=1).at(np.arange(1400) / 100.0)
    gain = nominal.robot.drive_gain
    return simulate(plant, plant.nominal_values, gain, motion, nominal, Sensors(0.005), payload)


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
    predicted = (fit.gear_friction_bias @ UNDER_LOAD)[: len(change)] / without.estimate.std
    assert np.linalg.norm(change) > 10.0
    # The difference is of second order: the friction's load is that of the biased fit.
    assert np.linalg.norm(change - predicted) < 0.15 * np.linalg.norm(change)
    assert not np.any(fit.gear_friction_bias[len(change) :])  # sensors of torque have no gains


def test_gains_that_a_weighed_payload_shows_are_biased_too() -> None:
    def weighed(under_load: np.ndarray) -> Fit:
        known = KnownPayload(
            "W", known_parameters(5.0, (0.05, 0.03, 0.12), (0.01, 0.0, 0.0, 0.01, 0.0, 0.01))
        )
        return identify([run(under_load), run(under_load, known)], as_recorded=True, drop=False)

    biased, without = weighed(UNDER_LOAD), weighed(np.zeros(6))
    assert np.all(biased.estimate.gain_estimated)
    change = biased.estimate.gain - without.estimate.gain
    predicted = (biased.gear_friction_bias @ UNDER_LOAD)[-6:]
    seen = np.abs(predicted) > 2.0 * without.estimate.gain_std
    assert np.sum(seen) >= 2
    np.testing.assert_allclose(change[seen], predicted[seen], rtol=0.3)


def test_a_file_keeps_the_bias(fit: Fit, tmp_path) -> None:
    write_fit(fit, tmp_path / "fit.json")
    np.testing.assert_allclose(read_fit(tmp_path / "fit.json").gear_friction_bias, fit.gear_friction_bias)


def test_nominal_gains_have_no_bias() -> None:
    bias = identify([run()], as_recorded=True, drop=False).gear_friction_bias
    assert np.any(bias[:-6])
    assert not np.any(bias[-6:])
