"""A gear that gives way, written into an MJCF as a second hinge: what MuJoCo makes of it."""

import numpy as np
import pytest

from exidyn.identification.errors import RobotError
from exidyn.identification.export.mjcf_gears import Gear, add_gears

mujoco = pytest.importorskip("mujoco")

ARM = b"""<mujoco>
  <compiler angle="{unit}"/>
  <default>
    <joint damping="3" stiffness="7" frictionloss="2" armature="0.4" limited="true" range="-1 1"/>
  </default>
  <option timestep="0.0005" integrator="implicitfast"/>
  <worldbody>
    <body><geom size="0.1"/>
      <joint name="turn" axis="0 0 1" stiffness="0"/>
      <frame euler="0 0 0.3">
      <body pos="0 0 0.5"> <!-- lifts -->
        <inertial mass="5" pos="0.4 0 0" diaginertia="0.02 0.1 0.1"/>
        <joint name="lift" pos="0.1 0 0" axis="0 1 0" damping="0" stiffness="0" frictionloss="0">
        </joint>
      </body>
      </frame>
    </body>
  </worldbody>
  <actuator><position joint="lift" kp="5000" kv="300"/></actuator>
  <keyframe><key name="home" qpos="0.1 0.2" qvel="0 0.5"/></keyframe>
</mujoco>
"""
RADIANS, DEGREES = (ARM.replace(b"{unit}", unit) for unit in (b"radian", b"degree"))
LOAD = 5 * 9.81 * 0.3
"""Torque of gravity on the lift where it is at zero [N m]."""


def with_gears(*gears, text=RADIANS):
    made, changes = add_gears(text, ".", "arm.xml", gears)
    return mujoco.MjModel.from_xml_string(made.decode()), made, changes


def twist_at_rest(model):
    """Where the lift's twist comes to rest, its motor held, and where its motor is."""
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 8000)
    return data.joint("lift_twist").qpos[0], data.joint("lift").qpos[0]


def test_an_elastic_gear_gives_way_by_the_load_over_its_stiffness():
    model, text, changes = with_gears(Gear("lift", 2000.0, 20.0, 0.0, 100.0))
    twist, motor = twist_at_rest(model)
    assert twist == pytest.approx(LOAD / 2000.0, rel=1e-3)  # down, as gravity turns about y
    assert motor == pytest.approx(LOAD / 5000.0, rel=1e-3)
    hinge = model.joint("lift_twist")
    assert (hinge.damping, hinge.armature, hinge.frictionloss) == (20.0, 0.0, 0.0)
    assert not hinge.limited[0]
    assert [(one.attribute, one.new, one.half) for one in changes[:1]] == [("stiffness", 2000.0, 100.0)]
    assert b"<!-- lifts -->" in text


def test_it_swings_about_the_same_axis_with_the_links_inertia():
    model, _, _ = with_gears(Gear("lift", 2000.0, 0.0))
    data = mujoco.MjData(model)
    lift, twist = (int(model.joint(name).dofadr[0]) for name in ("lift", "lift_twist"))
    data.qpos[1], data.qpos[2] = 0.3, -0.1
    mujoco.mj_forward(model, data)
    inertia = np.zeros((model.nv, model.nv))
    for column, unit in zip(inertia, np.eye(model.nv), strict=True):
        mujoco.mj_mulM(model, data, column, unit)
    assert inertia[twist, twist] == pytest.approx(0.1 + 5 * 0.3**2)
    assert inertia[lift, lift] - 0.4 == pytest.approx(inertia[twist, twist])
    assert inertia[lift, twist] == pytest.approx(inertia[twist, twist])


@pytest.mark.parametrize("text", [RADIANS, DEGREES])
def test_play_lets_the_link_fall_to_the_tooth_and_rest_there(text):
    text = text.replace(b'range="-1 1"', b'range="-60 60"') if text is DEGREES else text
    model, _, changes = with_gears(Gear("lift", 9000.0, 60.0, 0.02), text=text)
    np.testing.assert_allclose(model.joint("lift_twist").range, [-0.01, 0.01], rtol=1e-6)
    twist, _ = twist_at_rest(model)
    assert twist == pytest.approx(0.01, abs=2e-4)
    assert [(one.attribute, one.new) for one in changes] == [("range", 0.02)]


def test_keyframes_have_every_position_at_its_joint():
    model, text, _ = with_gears(Gear("lift", 2000.0, 20.0), Gear("turn", 3000.0, 30.0))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    names = ("turn", "turn_twist", "lift", "lift_twist")
    assert [data.joint(name).qpos[0] for name in names] == [0.1, 0.0, 0.2, 0.0]
    assert data.joint("lift").qvel[0] == 0.5
    assert text.count(b"_twist") == 2


def test_a_joint_that_slides_has_a_twist_that_slides():
    slides = DEGREES.replace(b'joint name="lift"', b'joint type="slide" name="lift"')
    model, _, changes = with_gears(Gear("lift", 9000.0, 60.0, 0.002), text=slides)
    assert model.joint("lift_twist").type[0] == mujoco.mjtJoint.mjJNT_SLIDE
    np.testing.assert_allclose(model.joint("lift_twist").range, [-0.001, 0.001])
    assert changes[0].unit == "m"


UNNAMED = RADIANS.replace(b'joint name="lift"', b"joint").replace(b'joint="lift"', b'joint="turn"')


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (RADIANS.replace(b'armature="0.4"', b""), "joint 'lift' has no armature"),
        (add_gears(RADIANS, ".", "", [Gear("lift", 2e3, 20.0)])[0], "already has a twist"),
        (UNNAMED, "no joint has the name"),
    ],
)
def test_what_cannot_give_way_is_refused(text, said):
    with pytest.raises(RobotError, match=said):
        add_gears(text, ".", "arm.xml", [Gear("lift", 2000.0, 20.0)])
