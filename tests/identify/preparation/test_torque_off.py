"""Stretches of a run in which a drive was off are left out, and named."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.fit.identification import identify
from exidyn.identification.preparation.even import torque_off
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal

from ...parts.small import two_joints
from ...parts.small.two_joint_files import loaded, run

RATE = 250.0


def let_go(recording: Recording, start: float, stop: float) -> Recording:
    """The recording with no current at the elbow between two times [s], though it moves on as before."""
    signal = recording.signals["current"]
    values = signal.values.copy()
    values[(signal.time >= start) & (signal.time < stop), 1] = 0.0
    return replace(recording, signals={**recording.signals, "current": Signal(signal.time, values)})


def test_a_stretch_without_current_in_motion_is_found_and_no_other():
    time = np.arange(0.0, 8.0, 1 / RATE)
    position = np.column_stack([np.sin(time), np.where(time < 4.0, np.sin(time), np.sin(4.0))])
    current = np.cos(3 * time)[:, None] + np.zeros((len(time), 2))
    current[250:500, 0] = 0.0
    current[1250:1500, 1] = 0.0  # it rests there
    current[600:630, :] = 0.0  # an eighth of a second
    off = torque_off(current, position, RATE)
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
