"""SDF, read by libsdformat where that is."""

import subprocess
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import (
    CoulombFriction,
    CurrentOffset,
    JointSpring,
    RigidBody,
    RotorInertia,
    ViscousFriction,
)
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.model import Model

from ...parts.runs.robots import six_axis, sliding
from ...parts.runs.simulated import known
from ...parts.system_needs import SDFORMAT, sdformat
from ..simulation.test_plant_forces import drawn

READER = Path(__file__).parents[2] / "parts" / "sdf_reader.cpp"
EFFECTS = (RigidBody(), RotorInertia(), ViscousFriction(), CoulombFriction())


def portable(robot, *more, limited=True, **changed):
    n = robot.dof
    limits = Limits(*np.outer([-2.0, 1.5, 3.0, 9.0, 90.0, 40.0], np.arange(1.0, n + 1.0)))
    robot = replace(robot, **({"limits": limits} if limited else {}), **changed)
    model = Model(robot, (*EFFECTS, *more))
    return Portable.of(known(model, drawn(model)))


def read_by_libsdformat(text, tmp_path):
    """Rows of links and joints as that library has them, by name."""
    SDFORMAT.require()
    command = ["pkg-config", "--cflags", "--libs", sdformat()]
    flags = subprocess.run(command, check=True, capture_output=True, text=True)
    program, model = tmp_path / "reader", tmp_path / "arm.sdf"
    made = ["g++", "-std=c++17", "-O0", str(READER), "-o", str(program), *flags.stdout.split()]
    subprocess.run(made, check=True, capture_output=True)
    model.write_text(text)
    read = subprocess.run([program, model], capture_output=True, text=True)
    assert read.returncode == 0, read.stderr
    assert not read.stderr
    rows = [line.split() for line in read.stdout.splitlines()]
    return {(kind, name): np.array(numbers, float) for kind, name, *numbers in rows}


@pytest.mark.parametrize("robot", [six_axis, sliding])
def test_libsdformat_reads_the_bodies_where_the_arm_has_them_and_its_joints(robot, tmp_path):
    arm = portable(robot(), JointSpring((robot().joints[1],)))
    found = read_by_libsdformat(FORMATS["sdf"].text(arm), tmp_path)
    kinematics, joints = arm.robot.kinematics, arm.joints
    data = kinematics.createData()
    pin.forwardKinematics(kinematics, data, np.zeros(arm.robot.dof))
    links = [numbers for (kind, _), numbers in found.items() if kind == "link"]
    for place, (name, numbers) in enumerate(zip(arm.robot.joints, links, strict=True), start=1):
        body = data.oMi[place].act(kinematics.inertias[place])
        moments = body.inertia[np.triu_indices(3)]
        np.testing.assert_allclose(numbers, [body.mass, *body.lever, *moments], atol=1e-9, err_msg=name)
    for place, name in enumerate(arm.robot.joints):
        turned = data.oMi[place + 1].rotation @ axis_of(kinematics, place)
        limits, stiffness = arm.robot.limits, joints.stiffness[place]
        rest = -joints.constant[place] / stiffness if stiffness else 0.0
        expected = [
            *turned, limits.position_lower[place], limits.position_upper[place], limits.torque[place],
            limits.velocity[place], joints.damping[place], joints.dry[place], rest, stiffness,
        ]  # fmt: skip
        np.testing.assert_allclose(found["joint", name], expected, atol=1e-9, err_msg=name)


def axis_of(kinematics, place):
    """Of a joint, in its frame, by how it moves."""
    data = kinematics.createData()
    velocity = np.zeros(kinematics.nv)
    velocity[place] = 1.0
    pin.forwardKinematics(kinematics, data, np.zeros(kinematics.nq), velocity)
    own = data.v[place + 1]
    return own.angular if np.linalg.norm(own.angular) > 0.5 else own.linear


def test_sdf_tells_what_it_lacks_and_limits_are_left_out_where_there_are_none():
    arm = portable(six_axis(), CurrentOffset(), JointSpring(("joint2",)), limited=False)
    root = ElementTree.fromstring(FORMATS["sdf"].text(arm))
    assert root.get("version") == "1.9"
    assert [joint.find("parent").text for joint in root.iter("joint")][0] == "world"
    assert root.find("model/joint/axis/limit/effort") is None
    left = FORMATS["sdf"].leaves_out(arm)
    assert any(line.startswith("rotor_inertia: ") for line in left)
    [constant] = [line for line in left if line.startswith("constant torque")]
    assert "joint1" in constant
    assert "joint2" not in constant  # is where its spring rests
