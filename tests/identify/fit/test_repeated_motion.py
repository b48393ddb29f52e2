"""A run held out that repeats a fitted motion is named as such."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.fit.fit_warnings import repeated_motions
from exidyn.identification.preparation.prepare import prepare
from exidyn.identification.recordings.recording import Recording, Signal

from ...parts.small.two_joints import model, motion, true_values

RATE = 200.0


def run(name, seed=0, start=0.0, payload=""):
    """Sixteen seconds of a motion, recorded from some time on, with its own noise."""
    noise = np.random.default_rng(len(name))
    whole = motion(int(20 * RATE), seed, rate=RATE)
    rows = slice(int(start * RATE), int((start + 16) * RATE))
    torque = model().torque(whole, true_values(model()))[rows]
    at = whole.position[rows] + 1e-4 * noise.normal(size=(rows.stop - rows.start, 2))
    time = np.arange(len(at)) / RATE
    signals = {"position": Signal(time, at), "torque": Signal(time, torque)}
    prepared = prepare(Recording(name=name, model=model(), signals=signals))
    return replace(prepared, motion=replace(prepared.motion, payload=payload))


@pytest.mark.parametrize("start", [0.0, 1.337])
def test_the_same_motion_again_proves_little(start):
    [warning] = repeated_motions([run("first")], [run("again", start=start)])
    assert warning.startswith("again repeats the motion of first")


def test_another_motion_and_the_same_with_a_payload_are_new():
    assert repeated_motions([run("first")], [run("other", seed=1), run("loaded", payload="L")]) == []
