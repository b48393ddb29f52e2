"""A joint that is silent now and then costs samples, not the identification."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.errors import NotFinite
from exidyn.identification.fit.identification import identify
from exidyn.identification.recordings.incomplete_samples import without_stale
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.recording import Signal
from exidyn.identification.recordings.recording_checks import check
from exidyn.identification.simulation.simulate import simulate

from ...parts.small import two_joints

SHARE = 0.005
"""Of samples in which a joint is silent."""


@pytest.fixture(scope="module")
def run():
    of = two_joints.model()
    motion = two_joints.trajectory(20.0).at(np.arange(0.0, 20.0, 0.002))
    return simulate(of, two_joints.true_values(of), two_joints.GAIN, motion, of)


def stale(run, seed=0):
    """The same run with holes in position and current of one joint at a time."""
    random = np.random.default_rng(seed)
    length = len(run.signals["position"])
    rows, joints = random.choice(length, int(SHARE * length), replace=False), random.integers(0, 2, length)
    signals = dict(run.signals)
    for name in ("position", "current"):
        values = np.array(signals[name].values)
        values[rows, joints[rows]] = np.nan
        signals[name] = Signal(signals[name].time, values)
    return replace(run, signals=signals), rows


def test_half_a_per_cent_of_stale_samples_does_not_change_what_is_identified(run, tmp_path):
    broken, rows = stale(run)
    write_recording(broken, tmp_path / "run.mcap")
    read = read_recording(tmp_path / "run.mcap")
    assert len(read.signals["position"]) == len(run.signals["position"]) - len(rows)
    assert np.isnan(broken.signals["position"].values).any()
    assert any("a joint was silent in 50 of 10000 samples (shoulder in " in d for d in read.warnings)
    whole, holed = identify([run]), identify([read])
    assert holed.base.names == whole.base.names
    apart = np.abs(holed.estimate.values - whole.estimate.values) / whole.estimate.std
    assert apart.max() < 0.5
    assert np.abs(holed.estimate.std / whole.estimate.std - 1.0).max() < 0.1


def test_temperatures_that_come_in_turn_are_joined(run):
    time = np.arange(0.0, 20.0, 0.1)
    values = np.full((len(time), 2), np.nan)
    values[::2, 0], values[1::2, 1] = 40.0 + time[::2], 50.0
    found = without_stale(replace(run, signals={**run.signals, "temperature": Signal(time, values)}))
    assert np.allclose(found.signals["temperature"].values[:-1, 0], 40.0 + time[:-1])
    assert np.array_equal(found.signals["temperature"].values[:, 1], np.full(len(time), 50.0))
    assert found.warnings == ()


def test_a_joint_that_never_answers_gives_a_warning_and_is_not_identified_from(run, tmp_path):
    values = np.array(run.signals["current"].values)
    values[:, 1] = np.nan
    write_recording(
        replace(run, signals={**run.signals, "current": Signal(run.signals["current"].time, values)}),
        tmp_path / "run.mcap",
    )
    found = read_recording(tmp_path / "run.mcap")
    assert any("current of elbow is empty" in warning for warning in found.warnings)
    with pytest.raises(NotFinite, match="current of elbow"):
        check(found)
