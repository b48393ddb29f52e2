"""MJCF: the same torque as MuJoCo's own inverse dynamics; what cannot be taken is refused by name."""

import numpy as np
import pytest

from exidyn.identification.errors import BrokenTree, RobotError, UnknownJoint
from exidyn.identification.robot_files.robot_file import model_text, parse_model, read_model

from ...parts.mujoco_models import random_motion, require_same, smooth_torque

ARM = """<mujoco model="small"><compiler angle="{angle}"/>{head}
<default><joint damping=".5"/>
  <default class="stiff"><joint stiffness="3" frictionloss=".2"/></default></default>
<worldbody>
  <body name="base" pos="0 0 .5" quat="1 .2 0 .1">
    <geom type="box" size=".1 .1 .1"/>
    <body name="upper" pos=".1 .02 .1" euler="10 0 20" {body}>
      <joint name="one" axis="0 1 .3" pos=".02 .01 0" armature=".3" ref="15" springref="30" class="stiff"/>
      <joint name="two" axis="1 0 0" pos="0 0 .05" range="-40 60"/>
      <geom type="capsule" size=".04" fromto="0 0 0 .3 0 .1" density="700"/>
      <body name="fixed" pos="0 .1 0" {body}>
        <inertial pos=".01 0 0" mass=".3" diaginertia="1e-3 2e-3 2e-3"/></body>
      <body name="lower" pos=".3 0 .1" {body}>
        <inertial pos=".1 0 .02" quat="1 1 0 .3" mass="1.2" diaginertia=".02 .03 .015"/>
        <joint name="slide" type="slide" axis="0 .6 .8" ref=".1" frictionloss=".7" {joint}/>
        <body name="hand" pos="0 0 .2" {body}>
          <inertial pos=".01 .02 .03" mass=".4" fullinertia="3e-3 2e-3 4e-3 1e-4 -2e-4 3e-4"/>
          <joint name="roll" armature=".01"/><site name="my_attachment_site" pos="0 .1 0"/>{hand}
        </body>
      </body>
    </body>
  </body>
</worldbody>{tail}</mujoco>"""


def small(head="", body="", joint="", hand="", tail="", angle="degree"):
    return ARM.format(head=head, body=body, joint=joint, hand=hand, tail=tail, angle=angle)


def model_of(text, tmp_path, robot=""):
    (tmp_path / "arm.xml").write_text(text)
    if not robot:
        return read_model(tmp_path / "arm.xml")
    (tmp_path / "robot.toml").write_text(robot)
    return read_model(tmp_path / "robot.toml")


@pytest.mark.filterwarnings("ignore:compiler attribute 'settotalmass'")
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"head": '<option gravity="1 2 -9"/>'},
        {"head": '<option><flag gravity="disable" spring="disable" damper="disable"/></option>'},
        {"head": '<compiler inertiafromgeom="true"/>', "hand": '<geom size=".05"/>'},
        {"head": '<compiler settotalmass="9"/>'},
        {"tail": '<actuator><position joint="roll" kp="9" gear="3" damping="2" armature=".04"/></actuator>'},
    ],
    ids=str,
)
def test_every_force_on_a_joint_is_taken(changes, tmp_path):
    text = small(**changes)
    if "head" in changes and "fromgeom" in changes["head"]:
        text = text.replace(
            '<inertial pos=".01 0 0" mass=".3" diaginertia="1e-3 2e-3 2e-3"/>', '<geom size=".03"/>'
        )
        text = text.replace('<joint name="slide"', '<geom size=".06"/><joint name="slide"')
    require_same(model_of(text, tmp_path), text, share=1e-9)


@pytest.mark.filterwarnings("ignore:.*gravcomp")
@pytest.mark.parametrize(("share", "by_motors"), [(1.0, False), (0.3, False), (1.0, True)])
def test_gravity_that_is_compensated_is_not_carried_by_motors(share, by_motors, tmp_path):
    text = small(body=f'gravcomp="{share}"')
    if by_motors:
        text = text.replace('<joint damping=".5"/>', '<joint damping=".5" actuatorgravcomp="true"/>')
    model = model_of(text, tmp_path)
    require_same(model, text, share=1e-9)
    assert model.robot.gravity[2] == pytest.approx(-9.81 * (1.0 if by_motors else 1.0 - share), abs=1e-12)


def test_values_limits_and_flange_are_those_of_the_file(tmp_path):
    tail = """<actuator>
      <motor joint="two" gear="-20" ctrlrange="-.5 .5" ctrllimited="true"/>
      <position joint="one" kp="5" forcerange="-9 7"/>
      <general joint="roll" gainprm="3" ctrlrange="-2 2" forcerange="-4 4"/>
      <velocity joint="slide" kv="3"/></actuator>"""
    model = model_of(small(tail=tail), tmp_path)
    stated = {name: prior.value for name, prior in model.stated.items()}
    assert stated == pytest.approx(
        {"Ia1": 0.3, "Ia2": 0, "Ia3": 0, "Ia4": 0.01, "Fv1": 0.5, "Fv2": 0.5, "Fv3": 0.5, "Fv4": 0.5,
         "Fc1": 0.2, "Fc2": 0, "Fc3": 0.7, "Fc4": 0, "Ks1": 3.0, "Ts1": -3.0 * np.radians(30)}
    )  # fmt: skip
    assert all(np.isinf(prior.std) for prior in model.stated.values())
    assert [name for name in model.names if name.startswith("Off")] == ["Off2", "Off3", "Off4"]
    robot = model.robot
    assert robot.joints == ("one", "two", "slide", "roll")
    np.testing.assert_allclose(robot.limits.torque, [7, 10, np.inf, 4])
    np.testing.assert_allclose(np.degrees(robot.limits.position_lower), [-np.inf, -40, -np.inf, -np.inf])
    np.testing.assert_allclose(robot.flange.translation, [0, 0.1, 0])
    assert not robot.inertias_stated


def test_a_model_of_an_mjcf_reads_back_from_a_robot_toml(tmp_path):
    model = model_of(small(), tmp_path)
    motion = random_motion(model.robot.dof)
    again = parse_model(model_text(model))
    np.testing.assert_allclose(smooth_torque(again, motion), smooth_torque(model, motion), rtol=1e-12)


def test_joints_that_do_not_move_are_held(tmp_path):
    text = small()
    model = model_of(text, tmp_path, 'urdf = "arm.xml"\nheld = {two = 0.4, slide = -0.2}')
    assert model.robot.joints == ("one", "roll")
    require_same(model, text, {"two": 0.4, "slide": -0.2}, share=1e-9)
    require_same(model_of(text, tmp_path, 'mjcf = "arm.xml"\njoints = ["two"]'), text, share=1e-9)
    text = small(tail='<equality><joint joint1="one" polycoef=".3 0 0 0 0"/></equality>')
    model = model_of(text, tmp_path)
    assert model.robot.joints == ("two", "slide", "roll")
    require_same(model, text, {"one": np.radians(15) + 0.3}, share=1e-9)
    text = small(tail=CUBE)
    joints = 'joints = ["one", "two", "slide", "roll"]'
    require_same(model_of(text, tmp_path, f'mjcf = "arm.xml"\n{joints}'), text, share=1e-9)


def test_a_fixed_tendon_couples_motors(tmp_path):
    tail = """<tendon><fixed name="belt">
        <joint joint="two" coef="2"/><joint joint="roll" coef="4"/></fixed></tendon>
      <actuator><motor joint="one"/><motor joint="two"/><motor joint="slide"/>
        <motor tendon="belt"/></actuator>"""
    coupling = np.eye(4)
    coupling[3, 1] = 0.5
    np.testing.assert_allclose(model_of(small(tail=tail), tmp_path).robot.coupling, coupling)
    only = tail.replace('<motor joint="two"/>', "")
    with pytest.raises(RobotError, match="pulls tendon 'belt' of two, roll"):
        model_of(small(tail=only), tmp_path)


CUBE = '<worldbody><body name="cube"><freejoint name="loose"/><geom size=".1"/></body></worldbody>'
TIE = '<equality><joint name="tie" joint1="one" joint2="two"/></equality>'
LOOP = '<equality><connect name="loop" body1="hand" body2="base" anchor="0 0 0"/></equality>'
CABLE = """<tendon><fixed name="cable" stiffness="3">
  <joint joint="one" coef="1"/><joint joint="two" coef="1"/></fixed></tendon>"""
ROPE = """<worldbody><site name="post"/></worldbody><tendon><spatial name="rope">
  <site site="post"/><site site="my_attachment_site"/></spatial></tendon>
  <actuator><motor name="winch" tendon="rope"/></actuator>"""


def actuator(text):
    return {"tail": f"<actuator>{text}</actuator>"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"tail": CUBE}, "joint 'loose' is free or a ball"),
        ({"head": '<option density="1.2"/>'}, "option density=1.2"),
        ({"joint": 'damping="1 2"'}, "joint 'slide' has damping that is a polynomial"),
        ({"joint": 'stiffness="1 2"'}, "joint 'slide' has stiffness that is a polynomial"),
        ({"tail": TIE}, "equality 'tie' couples"),
        ({"tail": LOOP}, "equality 'loop' closes a loop"),
        ({"tail": CABLE}, "tendon 'cable' has stiffness"),
        ({"tail": ROPE}, "actuator 'winch' pulls a spatial tendon"),
        (
            actuator('<muscle name="arm" joint="one" lengthrange="0 1"/>'),
            "actuator 'arm' has its own physics",
        ),
        (actuator('<general name="jet" site="my_attachment_site"/>'), "actuator 'jet' acts on a site"),
        (
            {"hand": '<body name="light"><geom size=".01"/></body>', "body": 'gravcomp="1"'},
            "gravcomp differs",
        ),
        ({"body": 'gravcomp="1"', "joint": 'actuatorgravcomp="true"'}, "actuatorgravcomp is set for slide"),
    ],
    ids=str,
)
def test_what_no_model_has_is_refused_by_name(change, message, tmp_path):
    with pytest.raises(RobotError, match=message):
        model_of(small(**change), tmp_path)


def test_wrong_files_and_names_are_refused(tmp_path):
    with pytest.raises(BrokenTree, match=r"arm.xml: not well-formed XML: "):
        model_of("<mujoco><worldbody><body/></mujoco>", tmp_path)
    with pytest.raises(BrokenTree, match="no joint moves"):
        model_of('<mujoco><worldbody><geom size="1"/></worldbody></mujoco>', tmp_path)
    with pytest.raises(UnknownJoint, match="elbow"):
        model_of(small(), tmp_path, 'mjcf = "arm.xml"\njoints = ["elbow"]')


def test_a_urdf_may_end_in_xml(tmp_path):
    from .test_urdf import INERTIAL

    text = f"""<robot name="arm"><link name="base"/><link name="upper">{INERTIAL}</link>
      <joint name="one" type="continuous"><parent link="base"/><child link="upper"/></joint></robot>"""
    assert model_of(text, tmp_path).robot.joints == ("one",)
