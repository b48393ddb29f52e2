"""Friction that falls during a run."""

import numpy as np
import pytest

from exidyn.identification.diagnosis.candidates.warming import warming
from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.words.sentences import sentence

from ...parts.small import two_joints
from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import record, sound_problem

FALL, TIME = 12.0, 4.0
"""Viscous friction that is gone once the joint is warm [N m s/rad], and its time constant [s]."""


def cold(role, motion, current):
    """Current with more friction at the start of a run."""
    left = FALL * np.exp(-(motion.time - motion.time[0]) / TIME)
    torque = left[:, None] * motion.velocity * [1.0, 0.0]
    return current + torque / two_joints.GAIN


def test_columns_are_friction_that_falls():
    at = sound_problem()
    run = at.runs[0]
    [viscous, *_] = [candidate for candidate in warming(at.model) if candidate.joints == (1,)]
    columns = viscous.reshaped({"time": TIME}).columns(run)[:, :, 0]
    cold = np.exp(-(run.motion.time - run.motion.time[0]) / TIME)
    np.testing.assert_allclose(columns[:, 1], cold * run.motion.velocity[:, 1])
    assert not np.any(columns[:, 0])


@pytest.mark.slow
def test_friction_that_falls_during_each_run_is_found_without_a_temperature():
    model = nominal_model()
    found = diagnose(model, record(change=cold))
    [one] = found.findings
    assert (one.effect, one.joints) == ("warming_friction", (0,))
    assert one.parameters["Fvw"].value == pytest.approx(FALL, rel=0.15)
    assert one.parameters["time"].value == pytest.approx(TIME, rel=0.25)
    assert "falls during a run" in sentence(one, model.robot.joints)
