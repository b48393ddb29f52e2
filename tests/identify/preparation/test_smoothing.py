"""A torque that was low-passed before it was recorded lacks the steps of dry friction beyond its band."""

import numpy as np
import pytest
from scipy import signal

from exidyn.identification.effects import Hysteresis
from exidyn.identification.fit.identification import common_filtering
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.preparation.spectra import recorded_band
from exidyn.identification.recordings.recording import Recording, Signal

from ...parts.small.two_joints import model, motion, true_values

RATE = 250.0
NEAR = 0.25
"""How near the edge of a filter is found: windows of 8 s resolve half a hertz."""
HYSTERESIS = {"Fh1": 4.0, "Fh2": 2.0}


def torque(of, run):
    values = [HYSTERESIS.get(n, v) for n, v in zip(of.names, true_values(of), strict=True)]
    return of.torque(run, np.array(values))


def low_passed(values, cutoff):
    return signal.sosfiltfilt(signal.butter(4, cutoff, fs=RATE, output="sos"), values, axis=0)


@pytest.fixture(scope="module")
def run():
    return motion(10_000, rate=RATE)


@pytest.mark.parametrize("cutoff", [1.5, 2.0, 4.0])
def test_it_was_recorded_up_to_where_it_was_filtered(run, cutoff):
    smooth = low_passed(torque(model(), run), cutoff)
    assert recorded_band(model(), run, smooth, RATE) == pytest.approx(cutoff, rel=NEAR)


def test_only_what_was_filtered_was_smoothed(run):
    # What is compared is one band for all joints; it is not cut for the sake of some.
    whole = torque(model(), run)
    half = np.column_stack([low_passed(whole, 2.0)[:, 0], whole[:, 1]])
    assert recorded_band(model(), run, half, RATE) == np.inf
    assert recorded_band(model(), run, torque(model(), run), RATE) == np.inf
    truth = torque(model(Hysteresis(presliding=0.01)), run)
    assert recorded_band(model(), run, truth, RATE) == np.inf
    smooth = low_passed(torque(model(), run), 2.0)
    noisy = smooth + 1e-3 * np.random.default_rng(0).normal(size=smooth.shape)
    assert recorded_band(model(), run, noisy, RATE) == np.inf


def test_runs_are_compared_as_far_as_all_were_recorded(run):
    whole = torque(model(), run)
    noise = 1e-3 * np.random.default_rng(0).normal(size=whole.shape)
    runs = [recording("noisy", run, whole + noise), recording("smooth", run, low_passed(whole, 2.0))]
    assert common_filtering(runs[:1], Filtering()).torque_cutoff >= 5.0
    assert common_filtering(runs, Filtering()).torque_cutoff == pytest.approx(2.0, rel=NEAR)
    assert common_filtering(runs, Filtering(torque_cutoff=4.0)).torque_cutoff == 4.0


def recording(name, run, values):
    signals = {"position": Signal(run.time, run.position), "torque": Signal(run.time, values)}
    return Recording(name=name, model=model(), signals=signals)
