from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification import model as module
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import CoulombFriction, Payload, RigidBody, RotorInertia
from exidyn.identification.errors import RecordingError
from exidyn.identification.fit.base_parameters import base_parameters
from exidyn.identification.fit.equations import assemble, decimated_regressor
from exidyn.identification.model import Model
from exidyn.identification.preparation.prepare import Filtering, prepare
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal
from exidyn.identification.simulation.simulate import Sensors, simulate
from exidyn.trajectories.random_motion import random_fourier

from ...parts.runs.robots import six_axis
from ...parts.small.two_joints import GAIN, MASS, model, trajectory, true_values

pytestmark = pytest.mark.numerical

FILTERS = Filtering(position_cutoff=20.0, torque_cutoff=8.0)
EXACT = Sensors(current_noise=0.0, encoder_noise=0.0, encoder_step=0.0)


def record(payload=None, seed=0, duration=12.0, sensors=Sensors(), of=None):  # noqa: B008
    plant = of or (model(Payload("L", payload.known)) if payload else model())
    motion = trajectory(duration, seed).at(np.arange(0.0, duration, 0.002))
    values, name = true_values(plant, 3.0), f"run {seed}"
    return simulate(plant, values, GAIN, motion, model(), sensors, payload=payload, name=name, seed=seed)


@pytest.fixture(scope="module")
def run():
    return prepare(record(), FILTERS)


@pytest.fixture(scope="module")
def base():
    return base_parameters(model())


def test_rows_are_the_whole_runs_regressor_filtered(run, base, monkeypatch):
    of = model()
    direct = run.decimation.apply(of.regressor(run.motion)[:, :, base.kept])
    for chunk in (37, 500, 10**6):
        monkeypatch.setattr(module, "CHUNK", chunk)
        regressor, known = decimated_regressor(of, base, run, run.motion)
        np.testing.assert_allclose(regressor, direct, atol=1e-12)
        assert not np.any(known)
    assert len(regressor) == len(run.decimated_current) == len(run.decimated_time) == len(run.weight)


@pytest.mark.parametrize("payload", [None, KnownPayload("L", MASS)])
def test_smooth_columns_formed_at_a_lower_rate_are_the_same(payload):
    """Inertia, gravity and their payload need no 500 Hz where positions are low-passed at 6 Hz."""
    slow = prepare(record(payload, duration=20.0), Filtering(position_cutoff=6.0, torque_cutoff=4.0))
    assert slow.decimation.thinned(8 * 6.0).step > 2
    of = model(Payload("L", MASS))
    base = base_parameters(of, ["", "L"])
    regressor, known = decimated_regressor(of, base, slow, slow.motion)
    direct = slow.decimation.apply(of.regressor(slow.motion)[:, :, base.kept])
    # the window's side lobes, -53 dB, fold into the pass band where samples are left out
    size = np.maximum(np.abs(direct).max(axis=0), 1e-9)
    np.testing.assert_array_less(np.abs(regressor - direct) / size, 1e-3)
    size = np.abs(of.known_torque(slow.motion)).max() + 1e-9
    np.testing.assert_allclose(known, slow.decimation.apply(of.known_torque(slow.motion)), atol=1e-3 * size)
    assert np.any(known) == (payload is not None)


def test_current_and_regressor_meet_without_noise(base):
    """The equations hold at their own times: no delay between current and regressor."""
    run = prepare(record(sensors=EXACT), FILTERS)
    equations = assemble(model(), base, [run])
    torque = equations.regressor @ (base.regrouping @ true_values(model()))
    sliding = equations.weight > 0
    wrong = (GAIN * equations.current - torque)[sliding]
    # what the position filter takes from the fast part of the motion, and the sign of velocity near reversal
    assert np.sqrt(np.mean(wrong**2)) < 2e-3 * np.sqrt(np.mean(torque[sliding] ** 2))
    late = (GAIN * np.roll(equations.current, 1, axis=0) - torque)[sliding]
    assert np.sqrt(np.mean(late**2)) > 20 * np.sqrt(np.mean(wrong**2))


def test_runs_follow_each_other(base):
    runs = [prepare(record(seed=seed), FILTERS) for seed in (0, 1)]
    equations = assemble(model(), base, runs)
    assert equations.runs[0].stop == equations.runs[1].start
    assert equations.runs[1].stop == len(equations.current)
    for rows, run in zip(equations.runs, runs, strict=True):
        np.testing.assert_array_equal(equations.current[rows], run.decimated_current)
        np.testing.assert_array_equal(equations.weight[rows], run.weight)
        alone = decimated_regressor(model(), base, run, run.motion)[0]
        np.testing.assert_array_equal(equations.regressor[rows], alone)
    assert equations.rate == runs[0].decimation.output_rate
    np.testing.assert_allclose(equations.noise**2, np.mean([run.noise**2 for run in runs], axis=0))


def test_known_payload_stands_on_the_right_of_its_runs_alone():
    body = KnownPayload("L", MASS)
    of = model(Payload("L", MASS))
    runs = [prepare(record(), FILTERS), prepare(record(body, 1), FILTERS)]
    base = base_parameters(of, ["", "L"])
    equations = assemble(of, base, runs)
    payload = [k for k, name in enumerate(equations.names) if name.rstrip("R").endswith("L")]
    assert payload
    assert not np.any(equations.known[equations.runs[0]])
    assert not np.any(equations.regressor[equations.runs[0]][:, :, payload])
    direct = runs[1].decimation.apply(of.known_torque(runs[1].motion))
    np.testing.assert_allclose(equations.known[equations.runs[1]], direct, atol=1e-12)


def test_coupled_motors_take_the_joints_power():
    """Motor torque times motor speed is joint torque times joint speed, row by row."""
    robot = replace(six_axis(), limits=Limits(*np.outer([-2.0, 2.0, 2.0, 9.0, 99.0, 99.0], np.ones(6))))
    of = Model(robot, (RigidBody(), RotorInertia(), CoulombFriction()))
    values = np.random.default_rng(0).normal(size=len(of.names))
    motion = random_fourier(robot.limits, 12.0).at(np.arange(0.0, 12.0, 0.002))
    recording = simulate(of, values, np.ones(6), motion, of, EXACT)
    motors = motion.velocity @ robot.coupling.T
    power = np.sum(recording.signals["current"].values * motors, axis=1)
    joints = np.sum(of.torque(motion, values) * motion.velocity, axis=1)
    np.testing.assert_allclose(power, joints, atol=1e-9 * np.abs(joints).max())
    run = prepare(recording, FILTERS)
    base = base_parameters(of)
    rows = decimated_regressor(of, base, run, run.motion)[0]
    torque = rows @ (base.regrouping @ values)
    wrong = np.where(run.weight > 0, torque - run.decimated_current, 0.0)
    assert np.linalg.norm(wrong) < 0.001 * np.linalg.norm(torque)
    other_way = np.where(run.weight > 0, torque @ robot.coupling - run.decimated_current, 0.0)
    assert np.linalg.norm(other_way) > 100 * np.linalg.norm(wrong)


def test_weight_is_zero_exactly_around_standstill(run):
    """One row's weight looks one row's distance to either side."""
    assert 0.02 < np.mean(run.weight == 0) < 0.5
    span, centres = run.decimation.factor, run.decimation.centres(len(run.motion))
    for seed in range(3):
        sliding = np.random.default_rng(seed).uniform(size=run.sliding.shape) > 0.7 / span
        weight = replace(run, sliding=sliding).weight
        for row, centre in enumerate(centres):
            near = sliding[centre - span : centre + span + 1]
            np.testing.assert_array_equal(weight[row], near.all(axis=0))


def test_temperature_and_encoder_noise_are_those_of_the_recording():
    recording = record(
        sensors=Sensors(current_noise=0.0, encoder_noise=1e-4, encoder_step=0.0), duration=30.0
    )
    position = recording.signals["position"]
    warm = Signal(position.time, np.linspace(20.0, 40.0, len(position))[:, None] * [1.0, 1.1])
    run = prepare(replace(recording, signals={**recording.signals, "temperature": warm}), FILTERS)
    assert np.ptp(run.motion.temperature, axis=0).min() > 10.0
    np.testing.assert_allclose(run.encoder_noise, 1e-4, rtol=0.1)


def test_runs_of_different_kinds_or_rates_are_refused(run, base):
    recording = record(seed=1)
    torque = {
        "position": recording.signals["position"],
        "torque": Signal(recording.signals["current"].time, GAIN * recording.signals["current"].values),
    }
    other = prepare(Recording("torques", model(), torque), FILTERS)
    assert other.measures == "torque"
    np.testing.assert_array_equal(other.gain, [1.0, 1.0])
    assert assemble(model(), base, [other]).gain_known
    with pytest.raises(RecordingError, match="measure current and torque"):
        assemble(model(), base, [run, other])
    slower = prepare(recording, replace(FILTERS, torque_cutoff=4.0))
    with pytest.raises(RecordingError, match="Hz, .* Hz"):
        assemble(model(), base, [run, slower])
