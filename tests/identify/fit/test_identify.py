"""End to end: from recordings of a simulated arm to its parameters."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from exidyn.identification.effects import Payload
from exidyn.identification.errors import NotExcited, RecordingError, RobotError
from exidyn.identification.fit.estimators import ESTIMATORS
from exidyn.identification.fit.estimators.least_squares import given_nominal
from exidyn.identification.fit.identification import identify
from exidyn.identification.preparation.prepare import prepare
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal
from exidyn.identification.simulation.simulate import Sensors, simulate

from ...parts.small.two_joints import GAIN, MASS, arm, model, trajectory, true_values

pytestmark = [pytest.mark.numerical, pytest.mark.slow]

BODY = KnownPayload("L", MASS)
SENSORS = Sensors(current_noise=0.01, encoder_noise=1e-5, encoder_step=0.0)


@cache
def record(seed=0, payload=None, rate=250.0):
    plant = model(Payload("L", MASS))
    motion = trajectory(20.0, seed).at(np.arange(0.0, 20.0, 1 / rate))
    return simulate(
        plant, true_values(plant, 3.0), GAIN, motion, model(), SENSORS,
        payload=payload, name=f"run {seed}", seed=seed,
    )  # fmt: skip


def truth(fit):
    """True values of the base parameters of a fit."""
    return fit.base.regrouping @ true_values(fit.model, 3.0)


@pytest.fixture(scope="module")
def runs():
    return [record(0), record(1)]


@pytest.fixture(scope="module")
def fit(runs):
    return identify(runs, validate=[record(5)])


def within(fit, deviations=4.0):
    return np.abs(fit.estimate.values - truth(fit)) < deviations * fit.estimate.std


def test_values_are_the_truth_as_nearly_as_stated(fit):
    assert within(fit).all()
    given = np.sqrt(np.diag(given_nominal(fit.estimate)))  # nominal gains may be off by more than that
    assert np.median(given / np.abs(truth(fit))) < 0.02
    assert {"YY1R", "MX1R", "Fv1", "Fc2", "Off1"} <= set(fit.names)
    assert fit.estimate.method == "weighted"
    assert fit.runs == ("run 0", "run 1")


def test_what_is_dropped_is_small_for_what_it_costs(fit, runs):
    full = identify(runs, drop=False)
    assert not full.dropped
    assert len(full.names) == len(fit.names) + len(fit.dropped)
    assert within(full).all()
    for name, value in fit.dropped.items():
        assert value == pytest.approx(full.value(name))


def test_validation_is_as_good_as_the_runs_used(fit):
    validation, used = fit.validation[0], fit.agreement[0]
    assert validation.run == "run 5"
    np.testing.assert_allclose(validation.residual_rms, used.residual_rms, rtol=0.3)
    assert np.all(validation.relative < 0.03)
    assert np.all(validation.r_squared > 0.999)
    assert np.all(validation.over_noise < 2.0)
    assert np.all(validation.over_noise > 0.6)


def test_agreement_numbers_by_hand(fit):
    agreement = fit.agreement[0]
    for joint in range(2):
        slides = agreement.weight[:, joint] > 0
        left = (agreement.measured - agreement.predicted)[slides, joint]
        measured = agreement.measured[slides, joint]
        assert agreement.residual_rms[joint] == pytest.approx(np.sqrt(np.mean(left**2)))
        assert agreement.relative[joint] == pytest.approx(np.linalg.norm(left) / np.linalg.norm(measured))
        assert agreement.r_squared[joint] == pytest.approx(1 - np.mean(left**2) / np.var(measured))
        assert agreement.over_noise[joint] == pytest.approx(
            np.sqrt(np.mean(left**2)) / agreement.noise[joint]
        )


def test_a_payload_that_only_validation_carries_gives_a_warning(fit, runs):
    unknown_payload = identify(runs, validate=[record(7, BODY)])
    assert any("run 7: carries 'L'" in warning for warning in unknown_payload.warnings)
    assert not any("carries" in warning for warning in fit.warnings)
    assert unknown_payload.validation[0].over_noise.max() > 5


def test_values_by_name_and_nominal_values(fit):
    assert fit.value("MX1R") == fit.value("MX1")
    with pytest.raises(KeyError, match="no base parameter 'XX9'.*MX1R"):
        fit.value("XX9")
    mean, deviation = fit.prior
    inertial = np.array([name[:2] not in ("Fv", "Fc", "Of") for name in fit.names])
    np.testing.assert_allclose(mean[inertial], truth(fit)[inertial], rtol=1e-9)
    assert np.all(np.isfinite(deviation[inertial]))
    assert np.all(np.isinf(deviation[~inertial]))


def test_gains_come_from_a_known_payload():
    nominal = replace(model(), robot=replace(arm(), drive_gain=GAIN * [0.85, 1.2]))
    runs, text = [replace(run, model=nominal) for run in (record(0), record(1, BODY))], []
    fit = identify(runs, progress=text.append)
    assert len(text) >= 4
    assert fit.estimate.method == "maximum likelihood"
    assert np.all(np.abs(fit.estimate.gain - GAIN) < 4 * fit.estimate.gain_std)
    assert np.all(fit.estimate.gain_std < 0.02 * np.abs(GAIN))
    assert within(fit).all()
    assert "MXLR" in fit.names or "MXL" in fit.names
    assert np.all(fit.agreement[1].over_noise < 2.0)


def test_torque_needs_no_gain():
    recording = record(0)
    torque = Signal(recording.signals["current"].time, GAIN * recording.signals["current"].values)
    signals = {"position": recording.signals["position"], "torque": torque}
    fit = identify([Recording("torques", model(), signals)])
    np.testing.assert_array_equal(fit.estimate.gain, [1.0, 1.0])
    assert within(fit).all()


@pytest.mark.parametrize("name", ESTIMATORS)
def test_every_estimator_end_to_end(name):
    fit = identify([record(0), record(1, BODY)], estimator=ESTIMATORS[name], drop=False)
    scale = np.maximum(np.abs(truth(fit)), 0.1)
    # the literal method is what it is; the others are within a few per cent
    assert np.max(np.abs(fit.estimate.values - truth(fit)) / scale) < (0.5 if name == "literal" else 0.15)


def test_at_a_hundred_hertz(fit):
    slow = identify([record(0, rate=100.0), record(1, rate=100.0)])
    assert within(slow).all()
    assert slow.filtering.rate == pytest.approx(100.0, rel=1e-6)


def test_jittering_stamps():
    recording = record(0, rate=500.0)
    random = np.random.default_rng(0)
    plant = model(Payload("L", MASS))
    time = np.arange(0.0, 20.0, 0.002) + random.uniform(-3e-4, 3e-4, 10_000)
    time -= time[0]
    motion = trajectory(20.0).at(time)
    jittered = simulate(plant, true_values(plant, 3.0), GAIN, motion, model(), SENSORS)
    fit = identify([jittered])
    even = identify([recording])
    shared = [name for name in even.names if name in fit.names]
    assert len(shared) > 8
    for name in shared:
        assert fit.value(name) == pytest.approx(even.value(name), rel=0.05, abs=0.05)


def test_only_where_position_and_current_were_both_recorded(fit):
    """A current that starts late and ends early is not continued by its first and last value."""
    recording = record(0)
    signals = dict(recording.signals)
    signals["current"] = signals["current"][1000:4000]
    run = prepare(replace(recording, signals=signals))
    assert run.motion.time[0] >= 4.0 - 0.004
    assert run.motion.time[-1] <= 16.0 + 0.004
    part = identify([replace(recording, signals=signals)])
    assert within(part, 5.0).all()


def test_nothing_to_identify_from():
    with pytest.raises(RecordingError, match="at least one"):
        identify([], validate=[record(0)])
    with pytest.raises(RobotError, match="no effects"):
        identify([record(0)], model=replace(model(), effects=()))


def still(signals):
    position = signals["position"]
    return {"position": Signal(position.time, position.values * [1.0, 0.0] + [0.0, 0.3])}


def of_another_clock(signals):
    current = signals["current"]
    return {"current": Signal(current.time + 1000.0, current.values)}


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        (still, NotExcited, "joint 2|Fv2"),
        (of_another_clock, RecordingError, "clock|overlap|share"),
        *((lambda signals, n=n: {k: v[:n] for k, v in signals.items()}, RecordingError, "only|too short")
          for n in (1, 20, 200)),
    ],
)  # fmt: skip
def test_runs_that_show_nothing_are_refused(change, error, words):
    recording = record(0)
    with pytest.raises(error, match=words):
        identify([replace(recording, signals={**recording.signals, **change(recording.signals)})])
