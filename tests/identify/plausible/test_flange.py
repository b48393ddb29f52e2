"""A body on the flange that nobody stated, or another one than stated, is named with its mass and center."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.rigid_regressor import body_regressor
from exidyn.identification.effects.payload import known_parameters
from exidyn.identification.plausible.flange import body_suspicions
from exidyn.identification.plausible.gate import doubts
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal

from ...parts.runs.logs import cobot_log

pytestmark = pytest.mark.numerical

LOG = cobot_log()
ROBOT = LOG.model.robot
MASS, CENTER = 12.0, (0.03, 0.14, 0.0)
"""Of the body: a tenth of the arm's mass."""
HALF = len(LOG.time) // 2


def runs(mass=MASS):
    """The first half of the log empty, the second with a body of a mass."""
    velocity = np.gradient(LOG.position, LOG.time, axis=0)
    motion = Motion.of(LOG.time, LOG.position, velocity, np.gradient(velocity, LOG.time, axis=0))
    columns = body_regressor(ROBOT.kinematics, motion, ROBOT.flange)
    values = dict(known_parameters(mass, CENTER, (0.0,) * 6)) if mass else {}
    order = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
    body = columns @ np.array([values.get(name, 0.0) for name in order])
    empty = recording("empty", LOG.torque, slice(None, HALF))
    return empty, recording("loaded", LOG.torque + body, slice(HALF, None))


def recording(name, torque, rows):
    signals = {"position": LOG.position, "current": torque / ROBOT.drive_gain}
    return Recording(name, LOG.model, {key: Signal(LOG.time[rows], v[rows]) for key, v in signals.items()})


def test_a_body_that_one_run_carries_is_named_and_no_other():
    [(run, suspicion)] = body_suspicions(runs(), LOG.model)
    assert run.name == "loaded"
    assert suspicion.name == "payload"
    assert suspicion.what.startswith("it carries a body on the flange that empty does not: 12.")
    assert "(30, 140, " in suspicion.what
    assert list(body_suspicions(runs(mass=0.0), LOG.model)) == []


@pytest.mark.long
def test_a_body_is_among_the_doubts_about_runs():
    assert any("12." in line for line in doubts(runs(), LOG.model))


@pytest.mark.parametrize(("mass", "center", "contradicted"), [(12.0, CENTER, False), (9.0, None, True)])
def test_a_stated_body_is_held_against_the_runs(mass, center, contradicted):
    empty, loaded = runs()
    loaded = replace(loaded, payload=KnownPayload("L", known_parameters(mass, center)))
    found = list(body_suspicions([empty, loaded], LOG.model))
    assert bool(found) is contradicted
    if contradicted:
        assert "stated is 9.00 kg" in found[0][1].what
        assert found[0][1].probability is None


def test_a_stated_center_is_held_against_the_runs():
    empty, loaded = runs()
    loaded = replace(loaded, payload=KnownPayload("L", known_parameters(MASS, (0.0, 0.0, 0.1))))
    [(_, suspicion)] = body_suspicions([empty, loaded], LOG.model)
    assert "stated is 12.0 kg at (0, 0, 100) mm" in suspicion.what
