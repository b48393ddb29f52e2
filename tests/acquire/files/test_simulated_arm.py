"""The arm of a simulation has the joints, held joints, mounting and gains of the recorded robot."""

from pathlib import Path

import numpy as np
import pytest

from exidyn.acquire.files.simulated_arm import controlled, import_runs, simulated_arm
from exidyn.identification.errors import RobotError, UnknownJoint
from exidyn.identification.in_mujoco.trial import Source
from exidyn.identification.robot_files.robot_file import model_text, parse_model, read_model

pytest.importorskip("mujoco")

STAND = """<mujoco>
  <worldbody>
    <body name="trunk">
      <freejoint name="float"/><geom size="0.1" mass="5"/>
      <body name="thigh" pos="0 0.1 0">
        <joint name="hip" axis="0 1 0" armature="0.01"/><geom size="0.05" mass="1" pos="0 0 -0.1"/>
        <body name="calf" pos="0 0 -0.2">
          <joint name="knee" axis="0 1 0" armature="0.01"/><geom size="0.05" mass="0.5" pos="0 0 -0.1"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="hip"/><motor joint="knee"/></actuator>
</mujoco>
"""
ROBOT = """mjcf = "stand.xml"
joints = ["hip", "knee"]
held = { float = [0, 0, 1, 0, 1, 0, 0] }
gravity = [0, 0.5, -9.8]
inertial_tolerance = 0.05
[drive]
gain = 20
servo_gain = 1
"""


@pytest.fixture
def recorded(tmp_path, monkeypatch):
    """The robot of a recording, which contains no path to the MJCF."""
    monkeypatch.chdir(tmp_path)
    Path("stand.xml").write_text(STAND)
    Path("robot.toml").write_text(ROBOT)
    return parse_model(model_text(read_model("robot.toml"))).robot


def test_the_simulated_arm_is_the_recorded_one(recorded):
    robot = simulated_arm(Path("stand.xml"), recorded).robot
    assert robot.joints == ("hip", "knee")
    assert dict(robot.held) == {"float": (0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0)}
    np.testing.assert_array_equal(robot.gravity, [0.0, 0.5, -9.8])
    np.testing.assert_array_equal(robot.drive_gain, [20.0, 20.0])
    assert (robot.inertial_tolerance, robot.inertias_stated) == (0.05, True)
    # Upside down: the leg points upward.
    np.testing.assert_allclose(robot.kinematics.jointPlacements[1].rotation[2], [0.0, 0.0, -1.0], atol=1e-12)
    assert robot.kinematics.jointPlacements[1].translation[2] == 1.0


def test_a_joint_that_the_file_lacks_is_named(recorded):
    Path("other.xml").write_text(STAND.replace('"knee"', '"ankle"'))
    with pytest.raises(UnknownJoint, match="knee"):
        simulated_arm(Path("other.xml"), recorded)


def test_logs_without_a_robot_need_a_model_of_all_joints(recorded):
    Path("log.csv").write_text("t,q1,q2,tau1,tau2\n0,0,0,0,0\n")
    with pytest.raises(
        RobotError, match=r"joint 'float' is free or a ball.*Hold joints still in a robot.toml"
    ):
        import_runs(Path("stand.xml"), [Path("log.csv")])


def test_a_controller_replaces_motors(recorded):
    source, robot = Source(STAND.encode(), ".", "stand.xml"), simulated_arm(Path("stand.xml"), recorded).robot
    assert controlled(source, robot, [20.0, 30.0], [0.5]).text.count(b"<general") == 2
    for gains in ([1.0] * 3, [-1.0]):
        with pytest.raises(RobotError, match="--kp"):
            controlled(source, robot, gains, [0.0])
