"""Robot files: what is read, what is written and read back, and what is refused."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.newton_euler import link_frames
from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.effects import (
    EFFECTS,
    CoulombFriction,
    Payload,
    Prior,
    RigidBody,
    RotorInertia,
    ViscousFriction,
)
from exidyn.identification.errors import BrokenTree, RobotError, UnknownJoint, UnknownKey
from exidyn.identification.measurements import MEASUREMENTS
from exidyn.identification.model import Model
from exidyn.identification.robot_files.effect_rows import EFFECT_KEYS, key_of
from exidyn.identification.robot_files.mdh import ROW_KEYS as MDH_KEYS
from exidyn.identification.robot_files.robot_file import (
    builtin_names,
    model_text,
    parse_model,
    read_model,
    urdf_text,
)
from exidyn.identification.robot_files.robot_keys import KEYS
from exidyn.identification.robot_files.urdf import parse_urdf

DOCUMENT = Path(__file__).parents[3] / "docs" / "robot-toml.md"

TWO = """
[[link]]
joint = "shoulder"
rpy = [0.1, -0.2, 0.3]
origin = [0.1, 0.2, 0.3]
axis = [1.0, 2.0, -0.5]
mass = 4.1
center_of_mass = [0.1, 0.02, -0.3]
inertia = [0.4, 0.01, -0.02, 0.5, 0.03, 0.3]

[[link]]
joint = "lift"
link = "carriage"
kind = "prismatic"
axis = [0.0, 0.0, -2.0]
origin = [0.3, 0.0, 0.1]
mass = 2.7
center_of_mass = [0.01, 0.2, 0.1]
inertia = [0.1, 0.0, 0.0, 0.1, 0.0, 0.1]
"""

FULL = f"""
name = "pair"
gravity = [0.1, 9.7, -0.3]
inertial_tolerance = 0.07
[limits]
position_lower = [-1.1, 0.0]
position_upper = [1.3, inf]
velocity = 2.5
[drive]
gain = [-12.3, 4.56]
gain_tolerance = [0.03, 0.04]
gear_ratio = [101.0, 33.3]
direct_drive = ["shoulder"]
coupling = [[1.0, 0.01], [0.0, 1.0]]
[flange]
origin = [0.0, 0.1, 0.2]
rpy = [0.3, 0.0, 1.0]
{TWO}
[[effect]]
name = "rotor_inertia"
joints = ["lift"]
values = [1.7]
tolerance = 0.1
[[effect]]
name = "coulomb_friction"
values = [3.1, 0.7]
std = [inf, 0.123456789012345678]
reversal = 0.0071
[[effect]]
name = "viscous_friction"
[[effect]]
name = "payload"
label = "box"
known = [["M", 3.3], ["MX", -0.1]]
[[effect]]
name = "spring_balancer"
joint = "shoulder"
d21 = 0.5
d22 = 0.2
phi = -1.5
[prior]
Fv2 = [0.1, 0.3]
M1 = 4.0
"""


def motion(model: Model, payload: str = "") -> Motion:
    random = np.random.default_rng(3)
    position, velocity, acceleration, load, temperature = random.standard_normal((5, 9, model.robot.dof))
    return Motion(np.arange(9) * 0.01, position, velocity, acceleration, load, temperature, payload)


def assert_equal(found: Model, expected: Model) -> None:
    """Equal to the last digit, in all that a computation can see."""
    assert found.effects == expected.effects
    assert found.names == expected.names
    assert found.priors == expected.priors
    assert found.stated == expected.stated
    payload = next((e.name for e in expected.effects if isinstance(e, Payload)), "")
    one, other = motion(found, payload), motion(expected, payload)
    np.testing.assert_array_equal(found.regressor(one), expected.regressor(other))
    np.testing.assert_array_equal(found.known_torque(one), expected.known_torque(other))
    for name in ("name", "joints", "flange", "inertial_tolerance", "direct_drive"):
        assert getattr(found.robot, name) == getattr(expected.robot, name), name
    for name in ("drive_gain", "drive_gain_tolerance", "gear_ratio", "coupling", "gravity"):
        np.testing.assert_array_equal(getattr(found.robot, name), getattr(expected.robot, name), name)
    for field in fields(Limits):
        np.testing.assert_array_equal(
            getattr(found.robot.limits, field.name), getattr(expected.robot.limits, field.name)
        )


def with_every_effect() -> Model:
    robot = parse_model(TWO).robot
    needed = {"joint": "shoulder", "other": "lift", "d21": 0.5, "d22": 0.2, "phi": -1.5}
    kinds = [k for k in EFFECTS.values() if k is not RigidBody]
    effects = [k(**{f.name: needed[f.name] for f in fields(k) if f.name in needed}) for k in kinds]
    return Model(robot, (RigidBody(), *effects))


MODELS = {name: read_model(name) for name in builtin_names()}
MODELS |= {"full": parse_model(FULL), "every effect": with_every_effect()}
MODELS["friction alone"] = Model(MODELS["full"].robot, (CoulombFriction(("lift",)), RotorInertia()))


@pytest.mark.parametrize("name", MODELS)
def test_what_is_written_reads_back_to_the_last_digit(name):
    again = parse_model(model_text(MODELS[name]))
    assert_equal(again, MODELS[name])
    assert_equal(parse_model(model_text(again)), again)


@pytest.mark.parametrize("name", MODELS)
def test_urdf_has_the_same_torque(name):
    robot = MODELS[name].robot
    read = parse_urdf(urdf_text(MODELS[name]))
    read.model.gravity = robot.kinematics.gravity
    assert read.flange.isApprox(robot.flange, 1e-12)
    assert [f.child for f in link_frames(read.model)] == [f.child for f in link_frames(robot.kinematics)]
    np.testing.assert_array_equal(read.limits.velocity, robot.limits.velocity)
    for state in np.random.default_rng(4).standard_normal((5, 3, robot.dof)):
        expected = pin.rnea(robot.kinematics, robot.kinematics.createData(), *state)
        found = pin.rnea(read.model, read.model.createData(), *state)
        np.testing.assert_allclose(found, expected, atol=1e-11 * np.abs(expected).max())


def test_urdf_keeps_a_turned_base_and_links_between_joints():
    body = '<inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    links = "".join(
        f'<link name="{name}">{body}</link>' for name in ("floor", "base", "upper", "bracket", "lower")
    )
    chain = (("floor", "base", "fixed"), ("base", "upper", "continuous"), ("upper", "bracket", "fixed"),
             ("bracket", "lower", "continuous"))  # fmt: skip
    joints = "".join(
        f'<joint name="to_{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        '<origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/></joint>'
        for parent, child, kind in chain
    )
    first = parse_urdf(f'<robot name="arm">{links}{joints}</robot>').model
    text = urdf_text(Model(Robot("arm", first), (RigidBody(),)))
    second = parse_urdf(text).model
    assert all(f'<link name="{name}"' in text for name in ("base", "upper", "bracket", "lower"))
    state = np.random.default_rng(5).standard_normal((3, 2))
    expected = pin.rnea(first, first.createData(), *state)
    np.testing.assert_allclose(pin.rnea(second, second.createData(), *state), expected, atol=1e-12)


def test_values_and_tolerances_become_priors():
    stated = MODELS["full"].stated
    assert stated["Ia2"] == Prior(1.7, 0.1 * 1.7)
    assert stated["Fc1"] == Prior(3.1, np.inf)
    assert stated["Fc2"] == Prior(0.7, 0.123456789012345678)
    assert stated["Fv2"] == Prior(0.1, 0.3)
    assert stated["M1"] == Prior(4.0, np.inf)
    assert "Fv1" not in stated


def test_degrees_are_turned_to_radians_and_metres_left_alone():
    limits = parse_model(TWO + "[limits]\ndegrees = true\nvelocity = [180.0, 0.9]\ntorque = 7").robot.limits
    np.testing.assert_array_equal(limits.velocity, [np.pi, 0.9])
    np.testing.assert_array_equal(limits.torque, [7, 7])
    assert parse_model(TWO).effects == (RigidBody(),)
    assert parse_model("rigid_body = false\n" + TWO + '[[effect]]\nname = "rotor_inertia"').effects == (
        RotorInertia(),
    )


def test_rotors_of_an_mdh_table_become_an_effect():
    rows = "[[mdh]]\nIa = 3.0\n[[mdh]]\nalpha = 1.0\n[[mdh]]\nIa = 5.0"
    model = parse_model("effect = []\n" + rows)
    assert model.effects == (RigidBody(), RotorInertia(("joint1", "joint3")))
    assert model.stated["Ia3"].value == 5.0
    model = parse_model(rows + '\n[[effect]]\nname = "viscous_friction"')
    assert model.effects == (RigidBody(), RotorInertia(("joint1", "joint3")), ViscousFriction())
    model = parse_model(rows)
    assert model.effects[1:3] == (RotorInertia(("joint1", "joint3")), RotorInertia(("joint2",)))
    assert set(model.stated) == {"Ia1", "Ia3"}


def test_limits_and_flange_of_the_file_win_over_its_urdf(tmp_path):
    (tmp_path / "arm.urdf").write_text(urdf_text(MODELS["full"]))
    (tmp_path / "robot.toml").write_text(
        'urdf = "arm.urdf"\n[limits]\nvelocity = 9.0\n[flange]\norigin = [1, 2, 3]'
    )
    robot = read_model(tmp_path / "robot.toml").robot
    np.testing.assert_array_equal(robot.limits.velocity, [9.0, 9.0])
    np.testing.assert_array_equal(
        robot.limits.position_lower, [-1.1, -np.inf]
    )  # it has no upper limit: continuous
    np.testing.assert_array_equal(robot.flange.translation, [1, 2, 3])


def test_joints_of_a_urdf_that_are_not_named_are_held(tmp_path):
    whole = MODELS["full"].robot
    (tmp_path / "arm.urdf").write_text(urdf_text(MODELS["full"]))
    (tmp_path / "robot.toml").write_text(f'urdf = "arm.urdf"\njoints = ["{whole.joints[0]}"]')
    robot = read_model(tmp_path / "robot.toml").robot
    assert robot.joints == whole.joints[:1]
    assert robot.kinematics.inertias[1].mass == sum(body.mass for body in list(whole.kinematics.inertias)[1:])
    assert read_model(tmp_path / "arm.urdf", whole.joints[:1]).robot.joints == whole.joints[:1]


def test_a_bare_urdf_gets_the_usual_effects(tmp_path):
    (tmp_path / "arm.urdf").write_text(urdf_text(MODELS["full"]))
    model = read_model(str(tmp_path / "arm.urdf"))
    usual = ("link_inertia", "rotor_inertia", "viscous_friction", "coulomb_friction", "current_offset")
    assert [type(effect) for effect in model.effects] == [EFFECTS[name] for name in usual]
    assert model.robot.name == "arm"
    assert not model.stated


def test_a_file_that_names_no_effect_gets_those_of_a_bare_urdf(tmp_path):
    (tmp_path / "arm.urdf").write_text(urdf_text(MODELS["full"]))
    file = tmp_path / "robot.toml"
    file.write_text('urdf = "arm.urdf"\n')
    bare = read_model(tmp_path / "arm.urdf")
    assert read_model(file).effects == bare.effects
    assert parse_model("[[mdh]]\n[[mdh]]\nalpha = 1.0").effects == bare.effects
    file.write_text('urdf = "arm.urdf"\n[[effect]]\nname = "viscous_friction"\n')
    assert read_model(file).effects == (RigidBody(), ViscousFriction())
    file.write_text('urdf = "arm.urdf"\neffect = []\n')
    assert read_model(file).effects == (RigidBody(),)


def test_mdh_from_a_file(tmp_path):
    (tmp_path / "arm_mdh.toml").write_text('convention = "mdh-khalil"\n[[link]]\njoint = 1\nd = 0.2\n')
    (tmp_path / "robot.toml").write_text('mdh = "arm_mdh.toml"\nname = "one"')
    robot = read_model(tmp_path / "robot.toml").robot
    assert (robot.name, robot.joints) == ("one", ("joint1",))


EFFECT = TWO + '[[effect]]\nname = "coulomb_friction"\n'


WRONG = [
    ("format = 1\nname = = 3\n", RobotError, "not TOML.*line 2"),
    ("format = 2\n" + TWO, RobotError, "format 2.*reads format 1"),
    ("nmae = 'a'\n" + TWO, UnknownKey, "'nmae'.*name"),
    ("name = ''\n" + TWO, RobotError, "name: expected a text"),
    ("name = 'a'", RobotError, "exactly one of urdf, mjcf, mdh, link; found none"),
    ("urdf = 'a.urdf'\n" + TWO, RobotError, "exactly one of urdf, mjcf, mdh, link; found .'urdf', 'link'"),
    ("urdf = 'nowhere.urdf'", RobotError, "nowhere.urdf: cannot be read: No such file"),
    ("link = 3", RobotError, r"\[\[link\]\]"),
    ("joints = ['lift']\n" + TWO, RobotError, "joints selects joints of a urdf"),
    ("urdf = 'a.urdf'\njoints = ['a', 'a']", RobotError, "joints: expected a list of different texts"),
    ("urdf = 'a.urdf'\njoints = ['a']\nheld = {a = 1}", RobotError, "a in joints, which move, and in held"),
    ("urdf = 'a.urdf'\nheld = ['a']", RobotError, "expected held = "),
    ("urdf = 'a.urdf'\nheld = {a = 'up'}", RobotError, "held: a"),
    ("gravity = [0.0, 9.8]\n" + TWO, RobotError, "gravity: 2 values, expected 3"),
    ("gravity = [0.0, 0.0, nan]\n" + TWO, RobotError, "gravity.*nan"),
    ("inertial_tolerance = -0.1\n" + TWO, RobotError, "inertial_tolerance: -0.1 is less than 0"),
    (TWO + "[limits]\nspeed = 1", UnknownKey, "'speed'.*velocity"),
    (TWO + "[limits]\nvelocity = [1, 2, 3]", RobotError, "velocity: 3 values, expected 2"),
    (TWO + "[limits]\nvelocity = 'fast'", RobotError, "velocity: expected a number; found 'fast'"),
    (TWO + "[limits]\nvelocity = -1", RobotError, "velocity: -1 is less than 0"),
    (TWO + "[limits]\nposition_lower = 1\nposition_upper = 1", RobotError, "joint 1.*1 is not below"),
    (TWO + "[drive]\ngains = [1, 2]", UnknownKey, "'gains'.*gain"),
    (TWO + "[drive]\ngain = [0, 2]", RobotError, "gain.*zero"),
    (TWO + '[drive]\ndirect_drive = ["knee"]', UnknownJoint, "knee"),
    (TWO + "[drive]\ncoupling = [[1, 0]]", RobotError, "2 rows"),
    (TWO + "[flange]\nrotation = [[1, 0, 0], [0, 1, 0], [0, 0, 2]]", RobotError, "not a rotation"),
    (TWO + "[[link]]\nparent = 'knee'", UnknownJoint, "'knee'.*shoulder, lift"),
    (TWO + "[[link]]\nkind = 'screw'", RobotError, "'screw'.*revolute, prismatic"),
    (TWO + "[[link]]\njoint = 'lift'", BrokenTree, "two joints are called 'lift'"),
    (TWO + "[[link]]\nlink = 'carriage'", BrokenTree, "two links are called 'carriage'"),
    (TWO + "[[link]]\naxis = [0, 0, 0]", RobotError, "length 0"),
    (TWO + "[[link]]\nmass = -1", BrokenTree, "joint3: mass -1"),
    (TWO + "[[link]]\nmass = 1\ninertia = [1, 3, 0, 1, 0, 1]", BrokenTree, "principal moment of inertia -2"),
    (TWO + "[[effect]]\nname = 'stiction'", RobotError, "no effect 'stiction'. Effects: .*coulomb_friction"),
    (TWO + "[[effect]]\nvalues = [1]", RobotError, "effect.. name: expected a text"),
    ("mdh = [{sigma = [1]}]", RobotError, "sigma .1.; valid: 0"),
    (EFFECT + "fade = 1.0", UnknownKey, "'fade'.*joints.*reversal.*values"),
    (EFFECT + "joints = ['knee']", UnknownJoint, "'knee'.*shoulder, lift"),
    (EFFECT + "joints = 'lift'", RobotError, "expected a list; found 'lift'"),
    (EFFECT + "reversal = 'slow'", RobotError, "reversal: expected a number; found 'slow'"),
    (EFFECT + "values = [1, 2, 3]", RobotError, r"values \(Fc1, Fc2\): 3 values, expected 2"),
    (EFFECT + "values = [1, 2]\nstd = [1]", RobotError, "std: 1 values, expected 2"),
    (EFFECT + "values = [1, 2]\nstd = [1, -2]", RobotError, "-2 is less than 0"),
    (EFFECT + "values = [1, 2]\nstd = 1\ntolerance = 1", RobotError, "one of them"),
    (EFFECT + "tolerance = 0.1", RobotError, "needs values"),
    (TWO + "[[effect]]\nname = 'spring_balancer'", RobotError, "spring_balancer: needs joint, d21, d22, phi"),
    (EFFECT + "joints = [2]", UnknownJoint, "joints: 2: joints are given by name. Valid joints: shoulder"),
    (TWO + "[[effect]]\nname = 'payload'\nknown = [1]", RobotError, "payload"),
    (EFFECT + "[[effect]]\nname = 'coulomb_friction'", RobotError, "named twice: Fc1, Fc2"),
    (TWO + "[prior]\nFc1 = 1.0", UnknownKey, "'Fc1'.*XX1"),
    (TWO + "[prior]\nM1 = [1, 2, 3]", RobotError, "M1: 3 values, expected 2"),
]


@pytest.mark.parametrize(("text", "error", "message"), WRONG)
def test_what_is_wrong_is_reported_in_one_line(text, error, message, tmp_path):
    with pytest.raises(error, match=message) as caught:
        parse_model(text, tmp_path)
    assert "\n" not in str(caught.value)


def test_an_unknown_robot_lists_those_there_are():
    with pytest.raises(RobotError, match="'kr720'.*cobot, kr270"):
        read_model("kr720")


def test_files_that_are_no_text(tmp_path):
    (tmp_path / "robot.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(RobotError, match="not a text file"):
        read_model(tmp_path / "robot.toml")
    with pytest.raises(RobotError, match="cannot be read"):
        read_model(tmp_path)


def test_every_key_is_documented_and_the_example_is_read(tmp_path):
    text = DOCUMENT.read_text()
    keys = {*MDH_KEYS, *EFFECT_KEYS, *(key for table in KEYS.values() for key in table)}
    keys |= {f.name for kind in MEASUREMENTS.values() for f in fields(kind)} | set(MEASUREMENTS)
    keys |= {name for effect in EFFECTS.values() for name in map(key_of, fields(effect))} | set(EFFECTS)
    assert not sorted(key for key in keys if f"`{key}`" not in text)
    (tmp_path / "my_arm.urdf").write_text(urdf_text(MODELS["cobot"]))
    model = parse_model(DOCUMENT.read_text().split("```")[1].removeprefix("toml"), tmp_path)
    assert model.robot.drive_gain[2] == 11.0
    assert model.stated["Fc6"] == Prior(2.5, 0.3 * 2.5)
