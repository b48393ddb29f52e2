"""Bodies as described beside free ones, which can absorb a spring."""

import numpy as np
import pytest

from exidyn.identification.diagnosis.diagnose import diagnose

from ...parts.small import two_joints
from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import record

pytestmark = pytest.mark.slow


def with_spring(role, motion, current):
    """A spring of 40 N m along the first joint, and a bump of 3 N m that no body gives."""
    angle = motion.position[:, 0]
    torque = 40.0 * np.sin(angle) + 3.0 * np.exp(-(((angle - 0.2) / 0.25) ** 2))
    return current + np.outer(torque / two_joints.GAIN[0], [1.0, 0.0])


def test_a_spring_that_free_bodies_absorb_is_found_although_a_curve_is_found_beside_them():
    found = diagnose(nominal_model(), record(change=with_spring))
    spring = found.findings[0]
    assert (spring.effect, spring.joints, found.beliefs.conditional[0]) == ("spring_balancer", (0,), 0)
    assert 20.0 < spring.parameters["torque_most"].value < 40.0  # stated bodies may take a part of it
    assert any(one.parameter == "MZ1" and one.deviations > 100.0 for one in found.beliefs.absorbed_by)
