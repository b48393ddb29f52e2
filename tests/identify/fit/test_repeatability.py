"""Repeatability: equal runs agree; what changes with a condition is named with it."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import Payload
from exidyn.identification.fit.fit_file import read_fit, write_fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.repeatability import SHORTEST, SURE
from exidyn.identification.recordings.recording import KnownPayload, Signal
from exidyn.identification.simulation.simulate import Sensors, simulate

from ...parts.small.small_fit import summary
from ...parts.small.two_joints import GAIN, MASS, model, trajectory, true_values

pytestmark = [pytest.mark.numerical, pytest.mark.slow]

SENSORS = Sensors(current_noise=0.01, encoder_noise=1e-5, encoder_step=0.0)
SLOPE = -0.2
"""Change of viscous friction per degree [N m s/rad/K]."""


def record(seed, duration=25.0, settings=None, temperature=None, payload=None, **changes):
    """A run; `changes` are added to the true values of parameters."""
    plant = model(Payload("L", MASS)) if payload else model()
    values = true_values(plant, 3.0)
    for name, change in changes.items():
        values[plant.names.index(name)] += change
    motion = trajectory(duration, seed).at(np.arange(0.0, duration, 0.004))
    run = simulate(
        plant, values, GAIN, motion, model(), SENSORS, payload=payload, name=f"run {seed}", seed=seed
    )
    signals = dict(run.signals)
    if temperature is not None:
        time = signals["position"].time
        signals["temperature"] = Signal(time, np.full((len(time), 2), temperature))
    return replace(run, signals=signals, settings={**run.settings, **(settings or {})})


def test_equal_runs_agree_and_their_scatter_is_as_probable_as_stated():
    probabilities = []
    for first in range(0, 12, 6):
        result = identify([record(first + k) for k in range(6)], repeat=True).repeatability
        assert len(result.parts) == 6
        assert not result.differing
        probabilities += [parameter.probability for parameter in result.parameters]
    assert np.mean(np.array(probabilities) < 0.1) < 0.25
    # Intervals that are too wide would agree with anything.
    assert np.mean(np.array(probabilities) < 0.5) > 0.25


def test_friction_that_follows_temperature_is_named_with_it():
    temperatures = (20.0, 24.0, 28.0, 32.0, 36.0, 40.0)
    runs = [record(k, temperature=t, Fv1=SLOPE * (t - 30.0)) for k, t in enumerate(temperatures)]
    fit = identify(runs, repeat=True)
    (parameter,) = fit.repeatability.differing
    assert parameter.name == "Fv1"
    assert parameter.deviation == pytest.approx(-SLOPE * np.std(temperatures), rel=0.3)
    trend = parameter.follows[0]
    assert trend.condition == "temperature"
    assert abs(trend.slope - SLOPE) < 4.0 * trend.std
    text = " ".join(summary(fit).split())
    assert "1 scatters more than their intervals say" in text
    assert "temperature, -0.2" in text


def test_a_number_in_the_settings_is_a_condition():
    gains = (10, 10, 20, 20, 30, 30)
    runs = [record(k, settings={"kp": str(g), "clock": "host"}, Fc2=0.05 * g) for k, g in enumerate(gains)]
    result = identify(runs, repeat=True).repeatability
    (parameter,) = result.differing
    assert parameter.name == "Fc2"
    assert [trend.condition for trend in parameter.follows] == ["setting kp"]
    assert abs(parameter.follows[0].slope - 0.05) < 4.0 * parameter.follows[0].std


def test_a_difference_without_a_cause_among_the_conditions_has_none():
    runs = [record(k, Off1=change) for k, change in enumerate((0.0, 4.0, -4.0, 4.0, 0.0, -4.0))]
    fit = identify(runs, repeat=True)
    (parameter,) = fit.repeatability.differing
    assert parameter.name == "Off1"
    assert not parameter.follows
    assert "not speed" in " ".join(summary(fit).split())


def test_one_run_is_split_and_a_short_one_is_not():
    result = identify([record(0, duration=4 * SHORTEST + 5.0)], repeat=True).repeatability
    assert len(result.parts) == 4
    assert not result.differing
    assert all(a.end <= b.start for a, b in zip(result.parts, result.parts[1:], strict=False))
    short = identify([record(0, duration=SHORTEST + 5.0)], repeat=True)
    assert not short.repeatability.parameters
    assert "Nothing to compare" in summary(short)


def test_a_payload_is_that_of_all_runs():
    body = KnownPayload("L", MASS)
    runs = [record(0), record(1), record(2, payload=body), record(3, payload=body)]
    result = identify(runs, repeat=True).repeatability
    assert len(result.parts) == 4
    assert not result.differing
    assert {"Fv1", "Fc2"} <= {parameter.name for parameter in result.parameters}


def test_it_is_stored_with_the_fit(tmp_path):
    fit = identify([record(0), record(1, Fc1=2.0)], repeat=True)
    write_fit(fit, tmp_path / "fit.json")
    assert read_fit(tmp_path / "fit.json").repeatability == fit.repeatability
    assert [parameter.name for parameter in fit.repeatability.differing] == ["Fc1"]
    assert fit.repeatability.differing[0].probability < SURE
    assert "undecided:" in summary(fit)
    assert identify([record(0)]).repeatability is None
