"""URDFs: what is read, and which culprit a broken one names."""

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.errors import BrokenTree, RobotError, UnknownJoint
from exidyn.identification.robot_files.urdf import movable_joints, parse_urdf

INERTIAL = '<inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'


def link(name):
    return f'<link name="{name}">{INERTIAL}</link>'


def joint(name, parent, child, kind="revolute", inside=""):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="0 0 1"/>{inside}</joint>'
    )


LIMIT = '<limit lower="-1" upper="2" velocity="3" effort="4"/>'
LINKS = link("base") + link("upper") + link("lower")
JOINTS = joint("shoulder", "base", "upper", inside=LIMIT) + joint("elbow", "upper", "lower", inside=LIMIT)


def robot(content):
    return f'<?xml version="1.0"?><robot name="arm">{content}</robot>'


def test_an_absent_or_zero_limit_is_none():
    limits = parse_urdf(robot(LINKS + JOINTS)).limits
    np.testing.assert_array_equal(limits.position_lower, [-1, -1])
    np.testing.assert_array_equal(limits.position_upper, [2, 2])
    np.testing.assert_array_equal(limits.velocity, [3, 3])
    np.testing.assert_array_equal(limits.torque, [4, 4])
    assert np.all(np.isinf([limits.acceleration, limits.jerk]))
    zero = '<limit lower="0" upper="0" velocity="0" effort="0"/>'
    limits = parse_urdf(
        robot(LINKS + joint("a", "base", "upper") + joint("b", "upper", "lower", inside=zero))
    ).limits
    assert np.all(np.isinf([limits.position_lower, limits.position_upper, limits.velocity, limits.torque]))


@pytest.mark.parametrize("inside", ["", LIMIT])
def test_a_continuous_joint_has_one_position_and_no_limit(inside):
    found = parse_urdf(
        robot(
            LINKS
            + joint("a", "base", "upper", "continuous", inside)
            + joint("b", "upper", "lower", "prismatic", LIMIT)
        )
    )
    assert found.model.nq == found.model.nv == 2
    np.testing.assert_array_equal(found.limits.position_upper, [np.inf, 2])


def test_an_axis_of_any_length_is_a_direction():
    text = robot(LINKS + JOINTS)
    long = parse_urdf(text.replace('"0 0 1"', '"0 0 5"', 1)).model
    data = long.joints[1].createData()
    long.joints[1].calc(data, np.zeros(2), np.zeros(2))
    np.testing.assert_allclose(np.ravel(data.S), [0, 0, 0, 0, 0, 1])


@pytest.mark.parametrize(("name", "own"), [("arm_tool0", True), ("fr3_link8", True), ("panda_tcp", False)])
def test_the_flange_is_that_of_the_controller_or_a_free_link(name, own):
    """A tool on the controller's own flange does not hide it; another link with a tool is no flange."""
    fixed = link(name) + joint("mount", "lower", name, "fixed", '<origin xyz="0.1 0.2 0.3"/>')
    found = parse_urdf(robot(LINKS + JOINTS + fixed))
    np.testing.assert_allclose(found.flange.translation, [0.1, 0.2, 0.3])
    assert found.flange_name == name
    further = parse_urdf(robot(LINKS + JOINTS + fixed + link("cup") + joint("c", name, "cup", "fixed")))
    assert further.flange_name == (name if own else "lower")
    assert further.flange.isIdentity() is not own


PLANAR = joint("elbow", "upper", "lower", "planar")
FLOATING = joint("elbow", "upper", "lower", "floating")
MIMIC = joint("elbow", "upper", "lower", inside='<mimic joint="shoulder"/>')


@pytest.mark.parametrize("elbow", [MIMIC, PLANAR, FLOATING, JOINTS.partition("</joint>")[2]])
def test_a_joint_that_is_held_belongs_to_the_link_before_it(elbow):
    text = robot(LINKS + joint("shoulder", "base", "upper", inside=LIMIT) + elbow)
    held = parse_urdf(text, moving=["shoulder"])
    assert tuple(held.model.names)[1:] == ("shoulder",)
    assert held.model.inertias[1].mass == 4.0
    np.testing.assert_array_equal(held.limits.velocity, [3])


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_a_joint_held_at_a_position_is_what_pinocchio_reduces_to(kind):
    origin = '<origin xyz="0.1 -0.2 0.3" rpy="0.4 0.5 -0.6"/><axis xyz="0 0.6 -0.8"/>'
    text = robot(LINKS + joint("shoulder", "base", "upper", kind, origin) + JOINTS.partition("</joint>")[2])
    whole = parse_urdf(text).model
    position = pin.neutral(whole)
    position[0] = 0.7
    reduced = pin.buildReducedModel(whole, [1], position)
    held = parse_urdf(text, held={"shoulder": 0.7}).model
    assert list(held.names) == list(reduced.names) == ["universe", "elbow"]
    motion = [np.array([value]) for value in (0.3, 1.1, -2.0)]
    expected = pin.rnea(reduced, reduced.createData(), *motion)
    np.testing.assert_allclose(pin.rnea(held, held.createData(), *motion), expected, rtol=1e-12)
    np.testing.assert_allclose(held.jointPlacements[1].homogeneous, reduced.jointPlacements[1], atol=1e-12)


def test_what_cannot_be_held_or_is_not_there_is_an_error():
    text = robot(LINKS + joint("shoulder", "base", "upper", inside=LIMIT) + PLANAR)
    with pytest.raises(RobotError, match="'elbow' cannot be held at a position: it is planar"):
        parse_urdf(text, held={"elbow": 0.1})
    with pytest.raises(UnknownJoint, match="'wrist'.*shoulder, elbow"):
        parse_urdf(robot(LINKS + JOINTS), held={"wrist": 0.1})
    with pytest.raises(UnknownJoint, match="'wrist'.*shoulder, elbow"):
        parse_urdf(robot(LINKS + JOINTS), moving=["shoulder", "wrist"])


def test_joints_that_move_by_themselves_and_those_that_do_not():
    assert movable_joints(robot(LINKS + JOINTS)) == (["shoulder", "elbow"], [])
    assert movable_joints(robot(LINKS + joint("shoulder", "base", "upper") + MIMIC)) == (
        ["shoulder"],
        ["elbow"],
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<robot><link></robot>", "not well-formed XML.*line 1"),
        ("", "not well-formed XML"),
        ("<sdf/>", "<sdf>, expected <robot>"),
        (robot(""), "no link"),
        (robot(LINKS + joint("shoulder", "base", "uper")), "joint 'shoulder' has child link 'uper'.*upper"),
        (robot(LINKS + joint("shoulder", "bse", "upper")), "joint 'shoulder' has parent link 'bse'"),
        (robot(LINKS + '<joint name="a" type="fixed"/>'), "joint 'a' has parent link ''"),
        (robot(LINKS + joint("shoulder", "base", "upper")), "2 roots.*base, lower"),
        (robot(LINKS + JOINTS + joint("loop", "lower", "base")), "form a loop.*base"),
        (robot(LINKS + JOINTS + joint("bar", "base", "lower")), "'lower' has two parents.*'bar'"),
        (robot(LINKS + link("base") + JOINTS), "link name used twice: base"),
        (
            robot(LINKS + link("hand") + JOINTS + joint("elbow", "lower", "hand")),
            "joint name used twice: elbow",
        ),
        (robot(LINKS + JOINTS).replace('"elbow"', '""'), "a joint has no name"),
        (robot(LINKS + JOINTS).replace('mass value="2"', 'mass value="-2"'), "mass -2 kg"),
        (robot(LINKS + JOINTS).replace('mass value="2"', 'mass value="nan"'), 'value="nan"'),
        (robot(LINKS + JOINTS).replace('"0 0 1"', '"0 0"', 1), 'axis xyz="0 0".*3'),
        (robot(LINKS + JOINTS).replace('"0 0 1"', '"0 0 0"', 1), "'shoulder' has an axis of length 0"),
        (
            robot(LINKS + joint("shoulder", "base", "upper") + PLANAR),
            "'elbow' is planar; valid types: revolute",
        ),
        (robot(LINKS + joint("shoulder", "base", "upper") + FLOATING), "'elbow' is floating"),
        (robot(LINKS + joint("shoulder", "base", "upper") + MIMIC), "'elbow' mimics"),
        (robot(LINKS + JOINTS.replace("revolute", "fixed")), "no joint moves"),
        ('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arm/></robot>', "expand it first"),
        (robot(LINKS + JOINTS).replace('izz="1"', 'izz="-1"'), "'shoulder': principal moment of inertia -1 "),
    ],
)
def test_a_broken_tree_names_the_culprit(text, message):
    with pytest.raises(BrokenTree, match=f"arm.urdf.*{message}") as caught:
        parse_urdf(text, "arm.urdf")
    assert "\n" not in str(caught.value)
