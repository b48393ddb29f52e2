"""Robots as xacro macros, expanded by the package of that name."""

import subprocess
import sys

import numpy as np
import pytest

from exidyn.identification.errors import BrokenTree, MissingPackage
from exidyn.identification.robot_files.geometry import read_geometry
from exidyn.identification.robot_files.robot_file import read_model

from .test_urdf import INERTIAL

LINK = f"""<?xml version="1.0"?>
<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="part" params="name parent reach">
    <link name="${{name}}">{INERTIAL}<collision><geometry><sphere radius="0.1"/></geometry></collision></link>
    <joint name="${{name}}_joint" type="revolute">
      <parent link="${{parent}}"/><child link="${{name}}"/><axis xyz="0 1 0"/>
      <origin xyz="${{2 * reach}} 0 0"/><limit lower="-1" upper="1" velocity="${{pi}}" effort="4"/>
    </joint>
  </xacro:macro>
</robot>
"""
ARM = """<?xml version="1.0"?>
<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="reach" default="0.25"/>
  <xacro:include filename="part.xacro"/>
  <link name="base"/>
  <xacro:part name="upper" parent="base" reach="$(arg reach)"/>
  <xacro:part name="lower" parent="upper" reach="0.5"/>
</robot>
"""


@pytest.fixture
def arm(tmp_path):
    (tmp_path / "part.xacro").write_text(LINK)
    (tmp_path / "arm.urdf.xacro").write_text(ARM)
    return tmp_path / "arm.urdf.xacro"


def test_macros_are_expanded_wherever_a_urdf_is_taken(arm, tmp_path):
    pytest.importorskip("xacro")
    command = [sys.executable, "-c", "import xacro; xacro.main()", str(arm)]
    (tmp_path / "plain.urdf").write_text(subprocess.check_output(command, text=True))
    (tmp_path / "robot.toml").write_text('urdf = "arm.urdf.xacro"')
    plain = read_model(tmp_path / "plain.urdf").robot
    for source in (arm, tmp_path / "robot.toml"):
        robot = read_model(source).robot
        assert robot.joints == ("upper_joint", "lower_joint")
        assert robot.kinematics.jointPlacements[1].isApprox(plain.kinematics.jointPlacements[1])
        np.testing.assert_array_equal(robot.kinematics.jointPlacements[2].translation, [1.0, 0.0, 0.0])
        np.testing.assert_array_equal(robot.limits.velocity, [np.pi, np.pi])
        assert read_geometry(source).ngeoms == 2


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (("part.xacro", "missing.xacro"), "arm.urdf.xacro: xacro: No such file"),
        (('<xacro:arg name="reach" default="0.25"/>', ""), "xacro: .*reach.*. If it needs arguments"),
        (('reach="0.5"', 'reach="${1 / 0}"'), "xacro: .*division by zero"),
        (("</robot>", ""), "xacro: "),
        (('parent="upper"', 'parent="uper"'), "has parent link 'uper', which does not exist"),
    ],
)
def test_macros_that_cannot_be_expanded_are_refused_in_one_line(arm, changed, message):
    pytest.importorskip("xacro")
    arm.write_text(ARM.replace(*changed))
    with pytest.raises(BrokenTree, match=message) as caught:
        read_model(arm)
    assert "\n" not in str(caught.value)


def test_without_xacro_the_message_names_the_extra(arm, monkeypatch):
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(MissingPackage, match=r'arm.urdf.xacro, .* needs xacro, .*pip install "\.\[xacro\]"'):
        read_model(arm)
