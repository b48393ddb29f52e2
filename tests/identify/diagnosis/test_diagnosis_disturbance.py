"""Torque that is periodic in time, whatever the arm does: no effect of the arm is named for it."""

import numpy as np
import pytest

from exidyn.identification.diagnosis.candidates.disturbance import disturbances
from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.words.sentences import sentence

from ...parts.small import two_joints
from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import problem, record

FREQUENCY, AMPLITUDE = 0.73, 2.0


def test_a_pump_beside_the_arm_is_unexplained_and_depends_on_time():
    def hum(role, motion, current):
        wave = AMPLITUDE * np.sin(2 * np.pi * FREQUENCY * motion.time + len(role))
        return current + np.outer(wave, [1.0, 0.0]) / two_joints.GAIN

    found = diagnose(nominal_model(), record(change=hum), "hum")
    [finding] = found.findings
    assert (finding.effect, finding.joints) == ("periodic_disturbance", (0,))
    assert finding.parameters["frequency"].value == pytest.approx(FREQUENCY, abs=1e-3)
    # Its phase is free in the held-out run too.
    assert found.torque_rms_after[0] < 0.1 * found.torque_rms_before[0]
    assert found.unexplained
    assert not finding.listed
    text = sentence(finding, found.joints)
    assert "is unexplained and depends on time" in text
    assert float(text.split("amplitude of ")[1].split()[0]) == pytest.approx(AMPLITUDE, rel=0.02)


def test_what_the_motion_has_itself_is_no_disturbance():
    def swinging(role, motion, current):
        return current + np.outer(20.0 * motion.position[:, 1], [1.0, 0.0]) / two_joints.GAIN

    at = problem(record(change=swinging))
    assert list(disturbances(at.model, at.without_findings, at.runs)) == []
