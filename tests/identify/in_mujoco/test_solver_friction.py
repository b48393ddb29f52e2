"""Dry friction of a model reverses as MuJoCo's solver lets it."""

import numpy as np
import pytest

from exidyn.identification.diagnosis.runs.rows import REVERSALS
from exidyn.identification.effects import CoulombFriction
from exidyn.identification.in_mujoco.mujoco_laws import TANH, reversal_velocities, with_solver_friction

from ...parts.servo_arms import ARM, described

mujoco = pytest.importorskip("mujoco")
LIGHT = ARM.replace('damping="0.5" armature="0.05"', 'frictionloss="3"').replace(
    'damping="1" armature="0.1"', 'frictionloss="0.01"'
)


def friction(model, joint, velocity):
    """Force of the solver against the motion of a joint that does not accelerate."""
    data = mujoco.MjData(model)
    data.qvel[joint] = velocity
    mujoco.mj_inverse(model, data)
    return float(-data.qfrc_constraint[joint])


@pytest.mark.parametrize("times", ["", ' solreffriction="0.05 1" solimpfriction="0.8 0.95 0.001"'])
def test_the_velocity_is_that_at_which_the_force_of_the_solver_reaches_its_limit(times):
    model = mujoco.MjModel.from_xml_string(LIGHT.replace('frictionloss="3"', f'frictionloss="3"{times}'))
    reached = reversal_velocities(model, ("shoulder", "elbow"))[1]
    for share in (0.25, 0.5, 0.9):
        assert friction(model, 1, share * reached) == pytest.approx(3.0 * share, rel=0.02)
    assert friction(model, 1, 1.2 * reached) == pytest.approx(3.0)


def test_only_joints_that_turn_more_slowly_than_usual_get_a_reversal_of_their_own():
    model, compiled = described(LIGHT), mujoco.MjModel.from_xml_string(LIGHT)
    changed = with_solver_friction(model, compiled)
    [usual, slow] = [effect for effect in changed.effects if isinstance(effect, CoulombFriction)]
    assert (usual.joints, slow.joints) == (("shoulder",), ("elbow",))
    assert usual.reversal == CoulombFriction().reversal
    own = TANH * reversal_velocities(compiled, ("shoulder", "elbow"))[1]
    assert CoulombFriction().reversal < slow.reversal == pytest.approx(min(own, REVERSALS[-1]))
    before, after = (dict(zip(of.names, of.nominal_values, strict=True)) for of in (model, changed))
    assert before == after
    np.testing.assert_array_equal(changed.robot.gravity, model.robot.gravity)
