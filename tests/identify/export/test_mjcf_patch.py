"""A user's MJCF with what was found: MuJoCo computes the model's torque, every other byte stays."""

import re
from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.command_line import main
from exidyn.identification.arm.robot import PositionServo
from exidyn.identification.effects import Prior
from exidyn.identification.effects.rigid_body import inertial_parameters, with_bodies
from exidyn.identification.errors import RobotError
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.export.changes import Spread
from exidyn.identification.fit.fit_file import write_fit
from exidyn.identification.fit.identified import identified, standard_parameters
from exidyn.identification.robot_files.robot_file import read_model

from ...parts.mujoco_models import compiled, patched, read_text, require_same
from ...parts.small.small_fit import plain_fit
from ...parts.small.two_joint_files import NOMINAL

ARM = b"""<?xml version="1.0"?>
<!-- my arm, <joint damping="7"> was too much -->
<mujoco model="mine">
  <compiler angle='degree'/>
  <option timestep = ".001"/>
  <default><joint damping=".5"/> <default class="big">
    <joint   armature=".2" frictionloss='1'/></default></default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="base"><geom size=".1" mass="3"/>
      <frame pos="0 0 .2">
      <body name="upper" pos="0 .1 0" >
        <joint name="one" axis="0 1 0"
               class = "big"  />  <!-- shoulder -->
        <inertial pos="0 0 .2"  mass="3" quat="1 .1 0 0"
                  diaginertia=".03 .02 .02"/>
        <body name="plate" pos="0 .1 .1"><geom size=".02" mass=".2"/></body>
        <body name="lower" pos="0 0 .4" euler="0 0 20">
          <geom type="capsule" size=".03" fromto="0 0 0 0 .02 .3" density="900"/>
          <joint axis="1 0 0" stiffness="4" springref='25' damping="1" range="-90 90" />
        </body>
      </body>
      </frame>
    </body>
  </worldbody>
  <actuator><position name="a" joint="one" kp="30" gear="2" armature=".01"/></actuator>
</mujoco>
"""
EDITED = re.compile(rb"<(?:joint|inertial)\b[^>]*>")


def found_in(model, links=(0, 1), **values):
    """The model with heavier links and other values of some parameters."""
    bodies = np.array([inertial_parameters(body) for body in list(model.robot.kinematics.inertias)[1:]])
    for link in links:
        bodies[link] *= 1.2 + 0.1 * link
        bodies[link, 6] += 0.02  # the centre of mass moves along x, and what that adds to the inertia
        bodies[link, [3, 5]] += 0.02
    stated = dict(model.stated) | {name: Prior(value, 0.01) for name, value in values.items()}
    return replace(model, robot=with_bodies(model.robot, bodies), stated=stated)


def test_mujoco_computes_what_was_found_and_the_rest_of_the_file_stays(tmp_path):
    nominal = read_text(ARM, tmp_path)
    assert nominal.robot.joints == ("one", "joint2")
    model = found_in(nominal, Ia1=0.3, Fv1=0.7, Fc2=0.4, Ks2=5.0, Ts2=-1.0)
    made = patched(model, ARM, tmp_path)
    require_same(model, made.text.decode())
    assert compiled(made.text.decode()).dof_frictionloss.tolist() == pytest.approx([1.0, 0.4])
    added = re.search(rb'\n +<inertial pos="[^"]*" mass="[^"]*" fullinertia="[^"]*"/>', made.text).group()
    assert EDITED.sub(b"", made.text.replace(added, b"", 1)) == EDITED.sub(b"", ARM)
    assert (
        b"""<joint name="one" axis="0 1 0"
               class = "big" armature="0.26" damping="0.7"  />  <!-- shoulder -->"""
        in made.text
    )
    assert b"""springref='11.459156' damping="1" range="-90 90" frictionloss="0.4" />""" in made.text
    assert re.search(rb"<inertial .*\n +fullinertia=", made.text)
    assert b"quat=" not in made.text


def test_every_number_that_changed_is_told_with_its_interval(tmp_path):
    nominal = read_text(ARM, tmp_path)
    made = patched(found_in(nominal, (), Fv1=0.7, Fc1=0.995, Ks2=5.0, Ts2=-1.0), ARM, tmp_path)
    told = {(one.where, one.attribute): one for one in made.changes}
    assert list(told) == [
        ("joint 'one'", "damping"),
        ("joint 'one'", "frictionloss"),
        ("joint 'joint2'", "stiffness"),
        ("joint 'joint2'", "springref"),
    ]
    damping, dry, _, rest = told.values()
    assert (damping.unit, damping.old, damping.new) == ("N m s/rad", 0.5, 0.7)
    assert damping.half == pytest.approx(0.0196)
    assert damping.told_apart
    assert not dry.told_apart
    assert (rest.unit, rest.old, rest.new) == ("rad", pytest.approx(np.radians(25)), pytest.approx(0.2))
    assert rest.half == pytest.approx(1.96 * 0.01 / 5.0 * np.hypot(1.0, 0.2))


def test_a_file_in_which_all_is_right_stays_as_it_is(tmp_path):
    made = patched(read_text(ARM, tmp_path), ARM, tmp_path)
    assert made.text == ARM
    assert made.changes == ()


@pytest.mark.parametrize("stated", ["of itself", "in a class"])
def test_damping_that_mujoco_makes_of_the_inertia_stays_as_it_was(stated, tmp_path):
    servo, own = b'joint="one" kp="30"', b'joint="one" kp="30" dampratio="1"'
    text = ARM.replace(servo, own)
    if stated == "in a class":
        text = ARM.replace(b'<default class="big">', b'<position dampratio="1"/><default class="big">')
    model = found_in(read_text(text, tmp_path), Ia1=0.9)
    made = patched(model, text, tmp_path)
    before, after = (compiled(one.decode()).actuator_biasprm[0] for one in (text, made.text))
    np.testing.assert_allclose(after, before, rtol=1e-7)
    [change] = [one for one in made.changes if one.attribute == "kv"]
    assert change.new == pytest.approx(-before[2])
    assert change.old > 1.1 * change.new
    assert (b"dampratio" in made.text) == (stated == "in a class")


def test_damping_that_mujoco_makes_of_the_inertia_in_another_file_is_said(tmp_path):
    servo = b'<position name="a" joint="one" kp="30" gear="2" dampratio="1"/>'
    (tmp_path / "servo.xml").write_bytes(b"<mujoco><actuator>" + servo + b"</actuator></mujoco>")
    text = re.sub(b"<actuator>.*</actuator>", b'<include file="servo.xml"/>', ARM)
    made = patched(found_in(read_text(text, tmp_path), Ia1=0.9), text, tmp_path)
    assert any(re.match(r"dampratio of servo 'a' in an included file", line) for line in made.left_out)


def test_gravity_is_written_where_it_was_found_to_be_another(tmp_path):
    nominal = read_text(ARM, tmp_path)
    kinematics = nominal.robot.kinematics.copy()
    kinematics.gravity.linear = np.array([1.0, 0.0, -9.7])
    model = replace(nominal, robot=replace(nominal.robot, kinematics=kinematics))
    made = patched(model, ARM, tmp_path)
    assert made.text == ARM.replace(b'timestep = ".001"', b'timestep = ".001" gravity="1 0 -9.7"')
    require_same(model, made.text.decode())
    compensated = ARM.replace(b"<body ", b'<body gravcomp="1" ')
    (tmp_path / "arm.xml").write_bytes(compensated)
    with pytest.warns(match="gravcomp"):
        read_model(tmp_path / "arm.xml")
    left = patched(model, compensated, tmp_path)
    assert left.text == compensated
    assert any("compensates" in sentence for sentence in left.left_out)


def test_friction_below_zero_is_written_as_none_and_said(tmp_path):
    made = patched(found_in(read_text(ARM, tmp_path), (), Fc1=-0.1), ARM, tmp_path)
    assert b'frictionloss="0"' in made.text
    assert any("frictionloss of one was identified as -0.1" in sentence for sentence in made.left_out)


@pytest.mark.parametrize(
    ("old", "new", "values", "message"),
    [
        (b'name="one"', b'name="uno"', {}, "has no joint one"),
        (b'pos="0 0 .4"', b'pos="0 0 .5"', {}, "joint 'joint2' is at another place than in the model"),
        (b"<compiler ", b'<compiler settotalmass="9" ', {}, "MuJoCo has another body behind joint 'one'"),
        (b"</mujoco>", b"</mujoc>", {}, "not well-formed XML"),
        (b"", b"", {"Ia1": 0.03}, "actuator of joint 'one' has more armature"),
    ],
)
@pytest.mark.filterwarnings("ignore:compiler attribute 'settotalmass'")
def test_what_cannot_be_written_is_refused(old, new, values, message, tmp_path):
    model = found_in(read_text(ARM, tmp_path), **values)
    changed = (
        ARM.replace(old, new).replace(b'joint="one"', b'joint="uno"')
        if b"uno" in new
        else ARM.replace(old, new)
    )
    with pytest.raises(RobotError, match=message):
        patched(model, changed, tmp_path)


def test_what_another_file_has_is_not_changed_here(tmp_path):
    body = ARM[ARM.index(b"<worldbody>") : ARM.index(b"<actuator>")]
    (tmp_path / "body.xml").write_bytes(b"<mujoco>" + body + b"</mujoco>")
    text = ARM.replace(body, b'<include file="body.xml"/>')
    model = found_in(read_text(text, tmp_path))
    with pytest.raises(RobotError, match=r"'one' is not in the text of this file, but in an included file"):
        patched(model, text, tmp_path)


def test_intervals_are_those_of_the_parameters_behind_them():
    fit = plain_fit()
    model, found = identified(fit), standard_parameters(fit)
    spread = Spread(model, found)
    assert spread.half(0, "damping") == pytest.approx(1.96 * model.stated["Fv1"].std)
    [first, _] = model.inertias
    own = np.where(np.isfinite(found.covariance[first, first]), found.covariance[first, first], 0.0)
    drawn = np.random.default_rng(0).multivariate_normal(found.values[first], own, 4000, check_valid="ignore")
    if np.all(np.isfinite(np.diag(found.covariance)[first])):
        halves = spread.of_body(0, lambda ten: ten[6:9] / ten[9])
        np.testing.assert_allclose(halves, 1.96 * np.std(drawn[:, 6:9] / drawn[:, 9:], axis=0), rtol=0.2)


def test_export_patches_the_file_of_the_arm(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = FORMATS["mjcf"].text(Portable.of(NOMINAL)).replace("<worldbody>", "<!-- mine --><worldbody>")
    (tmp_path / "arm.xml").write_text(text)
    write_fit(plain_fit(), "fit.json")
    assert main(["export", "fit.json", "--to", "mjcf", "--patch", "arm.xml", "--json", "made.json"]) == 0
    out = capsys.readouterr().out
    assert re.search(r"^joint '\w+'\ndamping +N m s/rad", out, re.MULTILINE) or "frictionloss" in out
    assert "<!-- mine -->" in (tmp_path / "arm-identified.xml").read_text()
    assert (tmp_path / "arm.xml").read_text() == text
    require_same(identified(plain_fit()), (tmp_path / "arm-identified.xml").read_text())
    assert main(["export", "fit.json", "--to", "json", "--patch", "arm.xml"]) != 0
    assert "--patch changes an MJCF or URDF" in capsys.readouterr().err
    (tmp_path / "arm.urdf").write_text(FORMATS["urdf"].text(Portable.of(NOMINAL)))
    assert main(["export", "fit.json", "--to", "urdf", "--patch", "arm.urdf"]) == 0
    assert re.search(r"^joint '\w+'\ndamping +N m s/rad", capsys.readouterr().out, re.MULTILINE)


SERVOS = re.sub(
    b"<actuator>.*</actuator>",
    b"""<default><default class="soft"><position kp="50" dampratio="1" forcerange="-3 3"/></default></default>
  <actuator><general joint="joint2" gainprm="7" gear="2" biastype="affine" biasprm="0 -7 -1"/>
    <position class="soft" name="b" joint="one"/></actuator>""",
    ARM,
).replace(b"<joint axis", b"<joint name='joint2' axis")


def test_stiffness_of_servos_is_written_where_a_log_has_no_current(tmp_path):
    nominal = read_text(SERVOS, tmp_path)
    assert not patched(nominal, SERVOS, tmp_path).changes
    servo = PositionServo(np.array([1.0, 2.0]), np.full(2, np.inf))
    robot = replace(nominal.robot, servo=servo, drive_gain=np.array([18.0, 10.0]),
                    drive_gain_tolerance=np.array([0.1, 0.05]))  # fmt: skip
    made = patched(replace(nominal, robot=robot), SERVOS, tmp_path)
    assert b"""<position class="soft" name="b" joint="one" kp="18" kv="0"/>""" in made.text
    # 20 N m/rad at the joint is 5 behind a gear of 2, which counts for position and for force.
    assert b"""gainprm="5" gear="2" biastype="affine" biasprm="0 -5 0"/>""" in made.text
    told = {(one.where, one.attribute): one for one in made.changes}
    assert [(one.old, one.new) for one in made.changes] == [
        (50.0, 18.0), (pytest.approx(told["actuator 'b'", "kv"].old), 0.0), (7.0, 5.0), (1.0, 0.0),
    ]  # fmt: skip
    assert told["actuator 'b'", "kp"].half == pytest.approx(1.96 * 1.8, rel=1e-3)
    assert told["actuator 'actuator1'", "kp"].half == pytest.approx(1.96 * 0.25, rel=1e-3)
    assert not patched(replace(nominal, robot=robot), made.text, tmp_path).changes
    assert told["actuator 'b'", "kv"].reason == "now in damping"
