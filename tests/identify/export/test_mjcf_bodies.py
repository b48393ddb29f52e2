"""Bodies that are fixed to the body of a joint: their sum is what was identified."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.diagnosis.candidates.base_tilt import under_gravity
from exidyn.identification.effects.rigid_body import body_inertia, inertial_parameters, with_bodies
from exidyn.identification.export.bodies import fixed_share
from exidyn.identification.robot_files.robot_file import read_model

from ...parts.mujoco_models import compiled, patched, read_text, require_same

ARM = b"""<mujoco>
  <worldbody>
    <body name="link" gravcomp="1">
      <inertial mass="1.2" pos="0 0 0.03" diaginertia="0.001 0.001 0.001"/>
      <joint name="hinge" axis="0 1 0" armature="0.1"/>
      <body name="camera" pos="0 0 0.1" gravcomp="1">
        <inertial mass="0.3" pos="0 0.02 0" diaginertia="0.0002 0.0002 0.0002"/>
      </body>
      <body name="bracket" pos="0.05 0 0.1" gravcomp="1"><geom size="0.02" mass="0.1"/></body>
      <body name="marker" gravcomp="1"/>
    </body>
  </worldbody>
</mujoco>
"""
PLAIN = ARM.replace(b' gravcomp="1"', b"")


def scaled(model, share):
    """The model with all bodies lighter by a factor."""
    bodies = [
        share * inertial_parameters(body) for body in list(model.robot.kinematics.inertias)[1:]
    ]  # mass and inertia alike
    return replace(model, robot=with_bodies(model.robot, np.array(bodies)))


@pytest.mark.parametrize("share", [1.1, 0.9, 0.5, 0.25, 0.01])
def test_the_sum_of_fixed_bodies_is_that_of_the_model(share, tmp_path):
    model = scaled(read_text(PLAIN, tmp_path), share)
    made = patched(model, PLAIN, tmp_path)
    simulated = compiled(made.text.decode())
    assert simulated.body_mass.sum() == pytest.approx(1.6 * share, rel=1e-6)
    require_same(model, made.text.decode())
    kept = simulated.body("camera").mass[0] == pytest.approx(0.3)
    assert kept == (share > 0.5)
    assert ("body 'camera'" in {change.where for change in made.changes}) != kept


def test_fixed_bodies_never_use_up_the_link():
    link = pin.Inertia(0.2, np.array([0.0, 0.0, 0.2]), np.diag([1e-4, 1e-4, 1e-4]))
    fixed = pin.Inertia(0.1, np.array([0.3, 0.0, 0.0]), np.diag([1e-4, 1e-4, 1e-4]))
    share = fixed_share(*(inertial_parameters(body) for body in (link + fixed, link, fixed)), 1.0)
    rest = body_inertia(inertial_parameters(link) - share * inertial_parameters(fixed))
    assert 0.0 < share < 0.1
    assert rest.mass > 0.1
    assert np.linalg.eigvalsh(0.5 * np.trace(rest.inertia) * np.eye(3) - rest.inertia).min() > 0.0


def test_gravcomp_is_removed_where_the_motors_carry_the_weight(tmp_path):
    model = read_text(PLAIN, tmp_path)
    made = patched(model, ARM, tmp_path)
    assert made.text == PLAIN
    assert {change.attribute for change in made.changes} == {"gravcomp"}


@pytest.mark.parametrize("text", [PLAIN, ARM])
def test_gravcomp_is_the_share_of_the_weight_that_motors_do_not_carry(tmp_path, text):
    model = read_text(PLAIN, tmp_path)
    made = patched(under_gravity(model, 0.3 * model.robot.gravity), text, tmp_path)
    assert {(change.attribute, round(change.new, 6)) for change in made.changes} == {("gravcomp", 0.7)}
    (tmp_path / "arm.xml").write_bytes(made.text)
    with pytest.warns(match="gravcomp"):
        again = read_model(tmp_path / "arm.xml")
    np.testing.assert_allclose(again.robot.gravity, 0.3 * model.robot.gravity)
