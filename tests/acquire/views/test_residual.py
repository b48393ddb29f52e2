"""The residual while the arm moves, against a simulated arm whose truth is known."""

import math
from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.views.residual import MARKS, LiveResidual, Samples, Scale, Torques, joint_torque
from exidyn.identification.effects import Hysteresis, Payload, Prior, RigidBody, known_parameters
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import Sensors, exact_current

from ...parts.pages.live_frames import SENSORS, measured
from ...parts.runs.robots import random_motion, six_axis

BODY = known_parameters(4.0, com=(0.02, 0.0, 0.1), inertia=(0.02, 0.0, 0.0, 0.02, 0.0, 0.01))
STAMPS = 1e6


@pytest.fixture(scope="module")
def model():
    return read_model("cobot")


def moving(model, seconds, **options):
    """As `measured`, but in the midst of the motion."""
    return measured(model, seconds, begin=3.0, **options)


def run(live, model, time, position, current, piece=25):
    """All torques of a run whose samples come in pieces."""
    none = np.full_like(current, np.nan)
    torque = joint_torque(model, current, none)
    parts = [
        live.add(Samples(STAMPS + time[rows], time[rows], position[rows], torque[rows]))
        for rows in (slice(start, start + piece) for start in range(0, len(time), piece))
    ]
    return Torques(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def rows_of(torques, time):
    """The sample in the middle of each window."""
    return np.searchsorted(time, torques.stamp - STAMPS - 1e-6)


def test_residual_of_the_true_model_is_the_noise(model):
    motion, position, current = moving(model, 6.0)
    torques = run(LiveResidual(model, 0.002), model, motion.time, position, current)
    usual = np.sqrt(np.mean(torques.measured**2, axis=0))
    # 1 % of the usual current, averaged over 51 samples, and as much again for encoder and friction's turns
    assert np.all(np.std(torques.residual, axis=0) < 2.0 * 0.01 * usual / np.sqrt(51))
    assert np.all(np.abs(np.mean(torques.residual, axis=0)) < 1e-3 * usual)
    np.testing.assert_allclose(torques.velocity, motion.velocity[rows_of(torques, motion.time)], atol=0.005)


def test_residual_of_an_unstated_body_is_its_torque(model):
    motion, position, current = moving(model, 6.0, hidden=BODY)
    torques = run(LiveResidual(model, 0.002), model, motion.time, position, current)
    body = Model(model.robot, (Payload("hidden", BODY),))
    missing = body.known_torque(motion)[rows_of(torques, motion.time)]
    largest = np.max(np.abs(missing), axis=0)
    assert np.all(largest[1:5] > 1.0)
    error = torques.residual - missing
    usual = np.sqrt(np.mean(torques.measured**2, axis=0))
    assert np.all(np.sqrt(np.mean(error**2, axis=0)) < 0.01 * largest + 0.005 * usual)


def test_stated_payload_is_nominal(model):
    motion, position, current = moving(model, 6.0, hidden=BODY)
    live = LiveResidual(model, 0.002, KnownPayload("L", BODY))
    torques = run(live, model, motion.time, position, current)
    usual = np.sqrt(np.mean(torques.measured**2, axis=0))
    assert np.all(np.std(torques.residual, axis=0) < 2.0 * 0.01 * usual / np.sqrt(51))


def test_pieces_of_any_length_give_the_same(model):
    hysteretic = model + Hysteresis()
    motion, position, current = moving(hysteretic, 3.0)
    samples = (motion.time, position, current)
    some, others = (run(LiveResidual(hysteretic, 0.002), model, *samples, piece) for piece in (7, 1500))
    for one, other in zip(some, others, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)


def test_friction_with_a_memory_goes_on_from_piece_to_piece(model):
    hysteretic = replace(model, effects=(RigidBody(), Hysteresis(presliding=0.02)))
    hysteretic = replace(hysteretic, stated={name: Prior(20.0, 1.0) for name in hysteretic.names[-6:]})
    exact = Sensors(current_noise=0.0, encoder_noise=0.0, encoder_step=1e-9)
    motion, position, current = moving(hysteretic, 4.0, sensors=exact)
    torques = run(LiveResidual(hysteretic, 0.002), hysteretic, motion.time, position, current)
    later = torques.stamp - STAMPS > 1.0  # it has forgotten where it began, which was not stated
    assert np.max(np.abs(torques.residual[later])) < 0.2  # of 20 N m


@pytest.mark.parametrize("cycle", [0.001, 0.012])
def test_torques_are_as_old_as_stated(model, cycle):
    motion, position, current = moving(model, 1.0, rate=1 / cycle)
    live = LiveResidual(model, cycle)
    torques = run(live, model, motion.time, position, current, piece=1)
    assert live.delay <= 0.085
    age = motion.time[-1] - (torques.stamp[-1] - STAMPS)
    assert live.delay - 1e-6 <= age < live.delay + 0.02 + cycle
    usual = np.sqrt(np.mean(torques.measured**2, axis=0))
    assert np.all(np.std(torques.residual, axis=0) < 0.01 * usual)


def test_windows_with_skipped_cycles_and_silent_joints_show_nothing(model):
    motion, position, current = moving(model, 3.0)
    kept = (motion.time < 1.0) | (motion.time > 1.2)
    position[motion.time == motion.time[1000], 3] = np.nan
    live = LiveResidual(model, 0.002)
    torques = run(live, model, motion.time[kept], position[kept], current[kept])
    at = torques.stamp - STAMPS
    silent = np.isnan(torques.residual).all(axis=1)
    near = (np.abs(at - 1.1) < 0.1 + live.delay) | (np.abs(at - 2.0) < live.delay)
    assert silent[np.abs(at - 2.0) < 0.5 * live.delay].all()
    assert silent[(at > 0.97) & (at < 1.23)].all()
    assert np.isfinite(torques.residual[~near]).all()
    assert np.isnan(torques.residual).all(axis=1).sum() < len(at) / 4


def test_clock_that_stands_still_or_goes_back_shows_nothing(model):
    motion, position, current = moving(model, 1.0)
    time = motion.time.copy()
    time[250:] -= 0.3
    torques = run(LiveResidual(model, 0.002), model, time, position, current)
    assert np.isnan(torques.residual).any()
    assert np.isfinite(torques.residual[[0, -1]]).all()


def test_torque_of_coupled_joints_is_that_which_made_the_currents():
    robot = replace(six_axis(), drive_gain=np.array([-40.0, 38.0, 25.0, -9.0, 8.0, 7.0]))
    of = Model(robot, (RigidBody(),))
    motion = random_motion(robot)
    current = exact_current(of, of.nominal_values, robot.drive_gain, motion)
    found = joint_torque(of, current, np.full_like(current, np.nan))
    np.testing.assert_allclose(found, of.torque(motion, of.nominal_values), rtol=1e-9, atol=1e-9)


def test_torque_is_the_controllers_where_it_gives_no_current(model):
    none, torque = np.full((3, 6), np.nan), np.arange(18.0).reshape(3, 6)
    np.testing.assert_array_equal(joint_torque(model, none, torque), torque)
    assert SENSORS.current_noise > 0  # the other tests mean something


@pytest.mark.parametrize(
    ("values", "mark"),
    [([-3.0, 5.0], 1.0), ([-3.0, 5.1], 10.0), ([-800.0, 1400.0], 1e3), ([0.02], 0.01), ([-450.0, 0.0], 1e2)],
)
def test_a_power_of_ten_is_marked_that_an_axis_has_room_for(values, mark):
    found = Scale(15.0).add(np.zeros(1), np.array([values]))
    assert found == pytest.approx(mark)
    assert np.ptp([*values, 0.0]) <= MARKS * found < 10.0 * np.ptp([*values, 0.0])


def test_what_is_no_longer_shown_is_forgotten():
    scale = Scale(15.0)
    scale.add(np.array([0.0]), np.array([[1e3]]))
    assert scale.add(np.array([14.0]), np.array([[1.0]])) == pytest.approx(1e3)
    assert scale.add(np.array([16.0]), np.array([[1.0]])) == pytest.approx(1.0)


def test_nothing_is_marked_where_nothing_is_known():
    scale = Scale(15.0)
    assert math.isnan(scale.add(np.zeros(1), np.full((1, 2), np.nan)))
    assert math.isnan(scale.add(np.ones(1), np.zeros((1, 2))))
