"""What no arm has in a robot file: refused, or said in a line."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.acquire.command_line import main
from exidyn.identification.errors import RobotError, RobotWarning
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.robot_files.kinematics import inertia_doubt
from exidyn.identification.robot_files.robot_file import builtin_names, model_text, parse_model, read_model

from ...parts.small import two_joints
from ...parts.small.two_joint_files import run

URDF = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="{xyz}"/><mass value="5"/>
<inertia ixx="{ixx}" iyy="{iyy}" izz="{izz}" ixy="{ixy}" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="100" velocity="3"/></joint>
<link name="cover"><inertial><mass value="20"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="screwed" type="fixed"><parent link="upper"/><child link="cover"/></joint></robot>"""
GOOD = {"xyz": "0.2 0 0.1", "ixx": 0.1, "iyy": 0.1, "izz": 0.1, "ixy": 0.0}
VECTOR = "gravity = [0.0, 0.0, -9.81]"


@pytest.fixture
def text():
    text = model_text(two_joints.model())
    assert VECTOR in text
    return text


@pytest.fixture
def urdf(tmp_path):
    def made(**other):
        path = tmp_path / "arm.urdf"
        path.write_text(URDF.format(**GOOD | other))
        return path

    return made


@pytest.mark.parametrize(
    ("gravity", "message"),
    [
        ("1.5", "expected a vector"),
        ("1e9", "expected a vector"),
        ("[0.0, 0.0, -981.0]", r"981 m/s\^2; it is at most 30"),
        ("[20.0, 20.0, 20.0]", "34.641"),
    ],
)
def test_gravity_is_a_vector_of_a_size_that_there_is(text, gravity, message):
    with pytest.raises(RobotError, match=message):
        parse_model(text.replace(VECTOR, f"gravity = {gravity}"))


@pytest.mark.parametrize("gravity", [[0.0, 0.0, 0.0], [0.0, 0.0, -1.62], [6.9, 0.0, 6.9], [0.0, -24.8, 0.0]])
def test_gravity_of_space_moon_a_wall_and_jupiter_is_read(text, gravity):
    model = parse_model(text.replace(VECTOR, f"gravity = {gravity}"))
    np.testing.assert_array_equal(model.robot.gravity, gravity)


def test_a_centre_of_mass_farther_than_an_arm_is_refused_with_the_limit(text, urdf):
    with pytest.raises(RobotError, match=r"link of shoulder: center of mass 1e\+09 m .* at most 10 m"):
        parse_model(text.replace("center_of_mass = [0.2,", "center_of_mass = [1e9,", 1))
    with pytest.raises(RobotError, match="link 'upper': center of mass 223.*in millimeters"):
        read_model(urdf(xyz="200 0 100"))


@pytest.mark.parametrize(
    ("inertia", "message"),
    [
        ({"izz": 0.3}, r"link 'upper': .* 0\.1, 0\.1, 0\.3 kg m²; the largest .* sum of the others"),
        ({"ixy": 0.2}, r"link 'upper': .* -0\.1, 0\.1, 0\.3 kg m²; none can be negative"),
    ],
)
def test_an_inertia_that_no_body_has_is_a_warning_with_link_and_numbers(urdf, capsys, inertia, message):
    """A heavy cover screwed to the link must not conceal it."""
    path = urdf(**inertia)
    with pytest.warns(RobotWarning, match=message) as warned:
        read_model(path)
    assert len(warned) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        assert main(["export", str(path), "--to", "json", "-o", str(path.with_suffix(".json"))]) == 0
    [line] = [one for one in capsys.readouterr().err.splitlines() if "warning" in one]
    assert re.match(rf"exidyn: warning: .*{message}", line)


def test_an_inertia_of_a_robot_file_is_a_warning_too(text, tmp_path):
    (tmp_path / "robot.toml").write_text(re.sub(r"inertia = \[0\.05,", "inertia = [0.2,", text, count=1))
    with pytest.warns(RobotWarning, match=r"joint 'shoulder': .* 0\.05, 0\.05, 0\.2 kg m"):
        read_model(tmp_path / "robot.toml")


@pytest.mark.parametrize("name", ["viscous_friction", "coulomb_friction"])
def test_friction_that_drives_is_a_warning(text, tmp_path, name):
    stated = f'name = "{name}"\nvalues = [3.0, -1.5]\ntolerance = 0.2'
    (tmp_path / "robot.toml").write_text(text.replace(f'name = "{name}"', stated))
    with pytest.warns(RobotWarning, match=r"F.2 = -1\.5 .*at least 0, as friction takes energy") as warned:
        read_model(tmp_path / "robot.toml")
    assert len(warned) == 1


def test_what_a_recording_has_in_it_is_no_warning(tmp_path):
    """The robot was warned of where its file was read; a folder of runs would say it over and over."""
    recording = run("run")
    robot = recording.robot
    kinematics = robot.kinematics.copy()
    kinematics.inertias[1] = pin.Inertia(5.0, np.zeros(3), np.diag([0.1, 0.1, 0.4]))
    doubtful = replace(recording.model, robot=replace(robot, kinematics=kinematics))
    write_recording(replace(recording, model=doubtful), tmp_path / "run.mcap")
    assert read_recording(tmp_path / "run.mcap").robot.joints == robot.joints


@pytest.mark.parametrize(
    "moments", [(0.0, 0.0, 0.0), (0.0, 1.0, 1.0), (0.012, 0.013, 0.025), (1e-9, 1e-9, 1e-9)]
)
def test_points_rods_and_rounded_plates_are_bodies(moments):
    assert not inertia_doubt(np.diag(moments), "link")


@pytest.mark.parametrize("name", builtin_names())
def test_built_in_robots_are_without_doubt(name, tmp_path):
    (tmp_path / "robot.toml").write_text(model_text(read_model(name)))
    read_model(tmp_path / "robot.toml")
