"""URDF: libsdformat and PyBullet read the same arm as Pinocchio, without masses that it does not have."""

from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.export import FORMATS
from exidyn.identification.robot_files.robot_file import read_model

from ...parts.runs.robots import six_axis, sliding
from ...parts.sdf import portable, read_by_libsdformat

WITH_WORLD = """<robot name="arm">
<link name="world"/><link name="stand"/><link name="first"><inertial><mass value="2"/>
<inertia ixx=".1" ixy="0" ixz="0" iyy=".1" iyz="0" izz=".1"/></inertial></link>
<joint name="foot" type="fixed"><parent link="world"/><child link="stand"/><origin xyz="0 0 .3"/></joint>
<joint name="one" type="revolute"><parent link="stand"/><child link="first"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


@pytest.mark.parametrize("robot", [six_axis, sliding])
def test_libsdformat_reads_the_bodies_and_joints_of_the_urdf(robot, tmp_path):
    """What moves on a base without mass would be dropped."""
    arm = portable(robot())
    rows = read_by_libsdformat(FORMATS["urdf"].text(arm), tmp_path)
    data = arm.robot.kinematics.createData()
    pin.forwardKinematics(arm.robot.kinematics, data, np.zeros(arm.robot.dof))
    links = [numbers for (kind, name), numbers in rows.items() if kind == "link" and name != "base"]
    for place, numbers in enumerate(links, start=1):
        body = data.oMi[place].act(arm.robot.kinematics.inertias[place])
        moments = body.inertia[np.triu_indices(3)]
        np.testing.assert_allclose(numbers, [body.mass, *body.lever, *moments], atol=1e-9)
    assert len(links) == arm.robot.dof
    assert [name for kind, name in rows if kind == "joint"] == list(arm.robot.joints)


@pytest.mark.parametrize("robot", [six_axis, sliding])
def test_pybullet_has_the_gravity_torque_of_pinocchio(robot, tmp_path):
    pybullet = pytest.importorskip("pybullet")
    arm = portable(robot())
    (tmp_path / "arm.urdf").write_text(FORMATS["urdf"].text(arm))
    position = 0.3 * np.arange(1.0, arm.robot.dof + 1.0)
    client = pybullet.connect(pybullet.DIRECT)
    body = pybullet.loadURDF(str(tmp_path / "arm.urdf"), flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
    pybullet.setGravity(*arm.robot.gravity)
    still = [0.0] * arm.robot.dof
    torque = pybullet.calculateInverseDynamics(body, list(position), still, still)
    pybullet.disconnect(client)
    kinematics = arm.robot.kinematics
    expected = pin.computeGeneralizedGravity(kinematics, kinematics.createData(), position)
    np.testing.assert_allclose(torque, expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.filterwarnings("ignore:.*radius of gyration")  # the inertia is drawn at random
def test_links_state_their_mass_and_the_base_stays(tmp_path):
    root = ElementTree.fromstring(FORMATS["urdf"].text(portable(six_axis())))
    mass = {link.get("name"): link.find("inertial/mass") for link in root.findall("link")}
    assert mass.pop("world") is None
    assert float(mass["flange"].get("value")) == 0.0
    assert float(mass["base"].get("value")) > 0.0
    assert all(float(value.get("value")) > 0.0 for name, value in mass.items() if name.startswith("link"))
    (tmp_path / "arm.urdf").write_text(WITH_WORLD)
    arm = portable(read_model(tmp_path / "arm.urdf").robot, limited=False)
    root = ElementTree.fromstring(FORMATS["urdf"].text(arm))
    names = [link.get("name") for link in root.findall("link")]
    assert sorted(names) == ["first", "flange", "stand", "world"]
    rows = read_by_libsdformat(FORMATS["urdf"].text(arm), tmp_path)
    assert ("joint", "one") in rows
    (tmp_path / "again.urdf").write_text(FORMATS["urdf"].text(arm))
    again = read_model(tmp_path / "again.urdf").robot
    assert again.joints == ("one",)
    assert again.kinematics.jointPlacements[1].isApprox(arm.robot.kinematics.jointPlacements[1])
