"""Collision geometry of an MJCF: where MuJoCo puts it, as far apart as MuJoCo measures."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.robot_files.geometry import read_geometry
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.clearances.clearance import random_positions
from exidyn.trajectories.clearances.collision import Collision

ARM = """<mujoco model="cell"><compiler angle="radian"/>
<default><joint damping="1"/></default>
<asset><mesh name="wedge" vertex="0 0 0  .1 0 0  0 .2 0  0 0 .3"/></asset>
<worldbody>
  <geom name="floor" type="plane" size="1 1 .1" pos="0 0 -.2"/>
  <geom type="box" size=".1 .2 .3" pos="1 .2 .3" euler="0 0 .4"/>
  <geom type="sphere" size=".5" contype="0" conaffinity="0"/>
  <body name="column" pos="0 0 .5" euler="0 .1 .2">
    <joint name="pan" axis="0 0 1" range="-2 2"/>
    <geom type="cylinder" size=".08 .1" pos="0 0 -.05"/>
    <body name="upper" pos=".05 0 .2">
      <joint name="lift" axis="0 1 0" range="-1.5 1.5" ref=".2"/>
      <geom type="capsule" size=".04" fromto="0 0 0 .3 .02 .1"/>
      <body name="fore" pos=".3 0 .1">
        <joint name="elbow" axis="0 1 0" pos="0 0 .02" range="-2 2"/>
        <geom type="ellipsoid" size=".05 .06 .12" pos=".1 0 0" euler="0 1.2 0"/>
        <body name="tool" pos=".2 0 0" euler=".3 0 .1">
          <geom type="mesh" mesh="wedge" mass=".2"/>
          <geom type="sphere" size=".03" pos="0 .1 0"/>
        </body>
      </body>
    </body>
  </body>
</worldbody></mujoco>"""


@pytest.fixture
def path(tmp_path):
    (tmp_path / "arm.xml").write_text(ARM)
    return tmp_path / "arm.xml"


def mujocos(path, robot, position):
    """MuJoCo's model and data where the joints are."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for joint, value in zip(robot.joints, position, strict=True):
        data.joint(joint).qpos[0] = value
    mujoco.mj_kinematics(model, data)
    return model, data


def touching(model):
    return np.flatnonzero(model.geom_contype | model.geom_conaffinity)


def test_geoms_are_where_mujoco_puts_them(path):
    robot, geometry = read_model(path).robot, read_geometry(path)
    assert [body.name for body in geometry.geometryObjects] == [
        "world_0", "world_1", "column_0", "upper_0", "fore_0", "tool_0", "tool_1",
    ]  # fmt: skip
    placed, data = geometry.createData(), robot.kinematics.createData()
    for position in random_positions(robot, 20):
        model, state = mujocos(path, robot, position)
        pin.updateGeometryPlacements(robot.kinematics, data, geometry, placed, position)
        for found, geom in zip(placed.oMg, touching(model), strict=True):
            np.testing.assert_allclose(found.translation, state.geom_xpos[geom], atol=1e-12)
            np.testing.assert_allclose(found.rotation.ravel(), state.geom_xmat[geom], atol=1e-12)


def test_distances_are_those_of_mujoco(path):
    """Its solver stops 1e-6 m from the truth; an ellipsoid is held in a hull that is up to 4 % larger."""
    robot, geometry = read_model(path).robot, read_geometry(path)
    collision = Collision.of(robot, geometry)
    names = [body.name for body in geometry.geometryObjects]
    compared = 0
    for position in random_positions(robot, 40, seed=1):
        model, state = mujocos(path, robot, position)
        found = dict(zip(collision.names, collision.distances(position[None])[0], strict=True))
        for name, distance in found.items():
            one, two = (int(touching(model)[names.index(body)]) for body in name.split(" to "))
            theirs = mujoco.mj_geomDistance(model, state, one, two, 10.0, np.zeros(6))
            if theirs > 0.0:
                rounder = 0.04 * 0.12 if "fore_0" in name else 0.0
                assert theirs - rounder - 1e-4 <= distance <= theirs + 1e-4
                compared += 1
    assert compared > 200


def test_held_joints_carry_their_geoms_along(path, tmp_path):
    (tmp_path / "robot.toml").write_text('mjcf = "arm.xml"\nheld = { lift = 0.7 }')
    robot, geometry = read_model(tmp_path / "robot.toml").robot, read_geometry(tmp_path / "robot.toml")
    assert robot.joints == ("pan", "elbow")
    position = np.array([0.3, -0.4])
    placed, data = geometry.createData(), robot.kinematics.createData()
    pin.updateGeometryPlacements(robot.kinematics, data, geometry, placed, position)
    model, state = mujocos(path, read_model(path).robot, np.array([0.3, 0.7, -0.4]))
    for found, geom in zip(placed.oMg, touching(model), strict=True):
        np.testing.assert_allclose(found.translation, state.geom_xpos[geom], atol=1e-12)


def test_an_mjcf_whose_geoms_touch_nothing_has_none(path):
    path.write_text(ARM.replace("<geom ", '<geom contype="0" conaffinity="0" ').replace(
        'size=".5" contype="0" conaffinity="0"', 'size=".5"'))  # fmt: skip
    assert read_geometry(path) is None
