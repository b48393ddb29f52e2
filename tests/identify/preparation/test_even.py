"""What a run needs besides positions, velocities that come late, and drives that were off."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.errors import NotRecorded
from exidyn.identification.fit.identification import identify
from exidyn.identification.preparation.even import torque_off
from exidyn.identification.preparation.prepare import prepare
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal
from exidyn.identification.simulation.simulate import simulate

from ...parts.small import two_joints
from ...parts.small.two_joint_files import loaded, run

pytestmark = pytest.mark.numerical


def test_a_run_of_a_controller_that_sent_no_currents_is_refused_in_a_sentence():
    whole = run("empty")
    none = Signal(np.zeros(0), np.zeros((0, 2)))
    signals = {name: signal for name, signal in whole.signals.items() if name != "torque"}
    with pytest.raises(NotRecorded, match="neither motor currents nor torques were recorded"):
        prepare(replace(whole, signals={**signals, "current": none}))


def test_torques_do_where_the_currents_are_empty():
    whole = run("empty")
    none = Signal(np.zeros(0), np.zeros((0, 2)))
    torque = whole.signals["current"]
    assert (
        prepare(replace(whole, signals={**whole.signals, "current": none, "torque": torque})).measures
        == "torque"
    )


def test_a_run_that_was_stopped_before_its_first_command_is_prepared_without():
    whole = run("empty")
    none = Signal(np.zeros(0), np.zeros((0, 2)))
    run_without = prepare(replace(whole, signals={**whole.signals, "command": none}))
    np.testing.assert_array_equal(run_without.motion.position, prepare(whole).motion.position)


RATE = 500.0


def late_velocity(late, factor=1.0):
    """A run whose controller's velocity comes late by some time a joint [s]."""
    model, path = two_joints.model(), two_joints.trajectory()
    time = np.arange(0.0, 20.0, 1 / RATE)
    run = simulate(model, two_joints.true_values(model), two_joints.GAIN, path.at(time), model)
    columns = [path.at(np.maximum(time - delay, 0.0)).velocity[:, j] for j, delay in enumerate(late)]
    velocity = Signal(time, factor * np.stack(columns, axis=1))
    return replace(run, signals={**run.signals, "velocity": velocity}), path


def error(late, factor=1.0):
    """Largest error of the prepared velocity over its largest value, a joint each."""
    run, path = late_velocity(late, factor)
    motion = prepare(run).motion
    true = path.at(motion.time).velocity
    return np.abs(motion.velocity - true).max(axis=0) / np.abs(true).max(axis=0)


@pytest.mark.parametrize("late", [(0.0, 0.0), (0.002, 0.002), (0.001, 0.004)])
def test_a_velocity_that_comes_late_is_brought_to_the_positions_time(late):
    assert np.all(error(late) < 1e-3)


def test_a_velocity_of_another_scale_is_not_used():
    assert np.all(error((0.0, 0.0), factor=1.2) < 1e-2)


SAMPLING = 250.0


def let_go(recording: Recording, start: float, stop: float) -> Recording:
    """The recording with no current at the elbow between two times [s], though it moves on as before."""
    signal = recording.signals["current"]
    values = signal.values.copy()
    values[(signal.time >= start) & (signal.time < stop), 1] = 0.0
    return replace(recording, signals={**recording.signals, "current": Signal(signal.time, values)})


def test_a_stretch_without_current_in_motion_is_found_and_no_other():
    time = np.arange(0.0, 8.0, 1 / SAMPLING)
    position = np.column_stack([np.sin(time), np.where(time < 4.0, np.sin(time), np.sin(4.0))])
    current = np.cos(3 * time)[:, None] + np.zeros((len(time), 2))
    current[250:500, 0] = 0.0
    current[1250:1500, 1] = 0.0  # it rests there
    current[600:630, :] = 0.0  # an eighth of a second
    off = torque_off(current, position, SAMPLING)
    assert off[:, 0].nonzero()[0].tolist() == list(range(250, 500))
    assert not off[:, 1].any()


def test_a_run_that_was_let_go_does_not_change_what_is_identified():
    body = KnownPayload("L", two_joints.MASS)
    whole = identify([run("empty"), loaded(body)])
    part = identify([run("empty"), let_go(loaded(body), 8.0, 16.0)])
    np.testing.assert_allclose(part.estimate.gain, whole.estimate.gain, rtol=0.01)
    assert part.value("Fc2") == pytest.approx(whole.value("Fc2"), rel=0.05)
    assert np.all(part.agreement[1].relative < 1.5 * whole.agreement[1].relative)
    [warning] = [one for one in part.warnings if "was off" in one]
    assert warning.startswith("loaded: the current of elbow is exactly zero for 8.0 s in which it moves")
    assert "or its resolution is too low" in warning  # as of joints whose current is read coarsely
    assert not any("was off" in one for one in whole.warnings)
