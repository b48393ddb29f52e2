"""Masses and inertias of descriptions in wrong units, placeholders, and real arms without a doubt."""

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.body_units import UNITS, arm_length, body_units
from exidyn.identification.errors import RobotWarning
from exidyn.identification.robot_files.robot_file import builtin_names, read_model

ARMS = builtin_names()


def scaled(name, mass=1.0, inertia=1.0):
    """Kinematics of a built-in arm whose numbers of mass and inertia are multiplied."""
    kinematics = read_model(name).robot.kinematics.copy()
    for joint in range(1, kinematics.njoints):
        body = kinematics.inertias[joint]
        kinematics.inertias[joint] = pin.Inertia(mass * body.mass, body.lever, inertia * body.inertia)
    return kinematics


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("mass", [0.4536, 1.0, 2.205])
def test_real_bodies_also_in_pounds_are_without_doubt(name, mass):
    assert body_units(scaled(name, mass)) == (True, ())


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("unit", UNITS)
def test_inertia_in_another_unit_is_named_with_its_link(name, unit):
    informative, [doubt] = body_units(scaled(name, inertia=UNITS[unit]))
    assert not informative
    assert "radius of gyration" in doubt
    assert unit in doubt.partition(" long: inertia in ")[2]


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("inertia", [1.0, 1e3, 1e9])
def test_masses_in_grams_are_named_whatever_the_unit_of_inertia(name, inertia):
    informative, doubts = body_units(scaled(name, 1e3, inertia))
    assert not informative
    assert doubts[0].endswith("long: in grams?")
    assert (
        f"{sum(body.mass for body in list(read_model(name).robot.kinematics.inertias)[1:]):.0f}" in doubts[0]
    )


@pytest.mark.parametrize("name", ARMS)
def test_inertia_below_that_of_metal_is_doubted_and_the_masses_still_count(name):
    informative, [doubt] = body_units(scaled(name, inertia=1e-3))
    assert informative
    assert "times less than that of solid metal" in doubt


@pytest.mark.parametrize("name", ARMS)
def test_placeholders_say_nothing_about_the_arm(name):
    kinematics = scaled(name)
    for joint in range(1, kinematics.njoints):
        kinematics.inertias[joint] = pin.Inertia(1e-3, np.zeros(3), 1e-6 * np.eye(3))
    informative, [doubt] = body_units(kinematics)
    assert not informative
    assert "placeholders" in doubt


def test_one_heavy_joint_is_in_grams_only_if_it_is_denser_than_metal():
    pendulum = pin.Model()
    pendulum.addJoint(0, pin.JointModelRY(), pin.SE3.Identity(), "joint")
    pendulum.inertias[1] = pin.Inertia(500.0, np.array([0.0, 0.0, 0.1]), 0.3 * np.eye(3))
    assert body_units(pendulum).doubts[0].startswith("masses of 500.0 kg in all")
    pendulum.inertias[1] = pin.Inertia(500.0, np.array([0.0, 0.0, 0.1]), 100.0 * np.eye(3))
    assert body_units(pendulum) == (True, ())


def test_lengths_in_millimeters_are_named():
    kinematics = scaled("cobot")
    for joint in range(2, kinematics.njoints):
        place = kinematics.jointPlacements[joint]
        kinematics.jointPlacements[joint] = pin.SE3(place.rotation, 1e3 * place.translation)
    informative, [doubt] = body_units(kinematics)
    assert not informative
    assert doubt.endswith("m long: lengths in millimeters?")


def test_a_description_without_masses_is_no_doubt_but_says_nothing():
    assert body_units(scaled("cobot", 0.0, 0.0)) == (False, ())


def test_the_length_leaves_out_the_way_from_the_base_to_the_first_joint():
    kinematics = scaled("cobot")
    length = arm_length(kinematics)
    kinematics.jointPlacements[1] = pin.SE3(np.eye(3), np.array([100.0, 0.0, 0.0]))
    assert arm_length(kinematics) == length


def test_a_description_with_a_wrong_unit_is_read_with_a_warning(tmp_path):
    text = """<robot name="arm"><link name="base"/><link name="upper"><inertial><origin xyz="0 0 0.2"/>
    <mass value="5"/><inertia ixx="90000" iyy="90000" izz="9000" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="100" velocity="3"/></joint></robot>"""
    path = tmp_path / "arm.urdf"
    path.write_text(text)
    with pytest.warns(RobotWarning, match=r"arm.urdf: link 'upper': radius of gyration 134 m .* in kg mm²"):
        read_model(path)
