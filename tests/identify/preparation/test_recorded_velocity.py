from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.preparation.prepare import prepare
from exidyn.identification.recordings.recording import Signal
from exidyn.identification.simulation.simulate import simulate

from ...parts.small import two_joints

pytestmark = pytest.mark.numerical

RATE = 500.0


def recording(late, factor=1.0):
    """A run whose controller's velocity comes late by some time a joint [s]."""
    model, path = two_joints.model(), two_joints.trajectory()
    time = np.arange(0.0, 20.0, 1 / RATE)
    run = simulate(model, two_joints.true_values(model), two_joints.GAIN, path.at(time), model)
    columns = [path.at(np.maximum(time - delay, 0.0)).velocity[:, j] for j, delay in enumerate(late)]
    velocity = Signal(time, factor * np.stack(columns, axis=1))
    return replace(run, signals={**run.signals, "velocity": velocity}), path


def error(late, factor=1.0):
    """Largest error of the prepared velocity over its largest value, a joint each."""
    run, path = recording(late, factor)
    motion = prepare(run).motion
    true = path.at(motion.time).velocity
    return np.abs(motion.velocity - true).max(axis=0) / np.abs(true).max(axis=0)


@pytest.mark.parametrize("late", [(0.0, 0.0), (0.002, 0.002), (0.001, 0.004)])
def test_a_velocity_that_comes_late_is_brought_to_the_positions_time(late):
    assert np.all(error(late) < 1e-3)


def test_a_velocity_of_another_scale_is_not_used():
    assert np.all(error((0.0, 0.0), factor=1.2) < 1e-2)
