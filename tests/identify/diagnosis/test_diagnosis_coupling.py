"""A motor that also turns with a neighbour of its joint, so that its link is not at the recorded position."""

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identify.diagnosis.candidates import hypotheses
from exidyn.identify.diagnosis.diagnose import diagnose
from exidyn.identify.diagnosis.words.sentences import sentence

from ...parts.small import two_joints
from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import problem, record

pytestmark = pytest.mark.slow

KINEMATICS = two_joints.arm().kinematics


def links(motor, velocity, acceleration, coupling):
    """Torque of the motors (t, n) [N m], by virtual power and not by the inverse of a transposed matrix."""
    data, back = KINEMATICS.createData(), np.linalg.inv(coupling)
    joints = [(back @ q, back @ v, back @ a) for q, v, a in zip(motor, velocity, acceleration, strict=True)]
    return np.array([pin.rnea(KINEMATICS, data, *state) @ back for state in joints])


def coupled(coupling):
    """Runs whose positions are those of the motors."""

    def change(role, motion, current):
        state = motion.position, motion.velocity, motion.acceleration
        more = links(*state, coupling) - links(*state, np.eye(2))
        return current + more / two_joints.GAIN

    return record(change=change)


@pytest.mark.parametrize(("motor", "other", "ratio"), [(1, 0, 1.0), (0, 1, -0.5)])
def test_columns_are_what_links_elsewhere_ask_of_both_motors(motor, other, ratio):
    at = problem(record(roles=("identify",)))
    coupling = np.eye(2)
    coupling[motor, other] = ratio
    [candidate] = [
        one
        for one in hypotheses("kinematic_coupling", at.model)
        if one.shape.get("moved") == motor + 1 and one.shape["ratio"] == ratio
    ]
    motion = at.runs[0].motion
    state = motion.position, motion.velocity, motion.acceleration
    more = links(*state, coupling) - links(*state, np.eye(2))
    np.testing.assert_allclose(candidate.columns(at.runs[0])[:, :, 0], more, atol=1e-9)
    assert np.max(np.abs(more)) > 1.0


def test_a_link_that_is_not_where_its_motor_states_is_found_with_its_ratio():
    coupling = np.array([[1.0, 0.0], [0.8, 1.0]])
    found = diagnose(nominal_model(), coupled(coupling), "coupled")
    [finding] = found.findings
    assert (finding.effect, finding.joints) == ("kinematic_coupling", (0, 1))
    assert finding.parameters["ratio"].value == pytest.approx(0.8, abs=0.02)
    text = sentence(finding, found.joints)
    assert "the recorded position of joint 2 is that of its motor" in text
    assert not set("{}[]") & set(text)
