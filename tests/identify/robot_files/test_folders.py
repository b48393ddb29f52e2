"""Descriptions that name files outside of their folder, and macros without an end."""

import struct

import numpy as np
import pytest

from exidyn.identification.errors import BrokenTree, RobotError
from exidyn.identification.robot_files import xacro_macros
from exidyn.identification.robot_files.folders import VARIABLE
from exidyn.identification.robot_files.geometry import read_geometry
from exidyn.identification.robot_files.mjcf import compile_mjcf
from exidyn.identification.robot_files.urdf import read_urdf

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
URDF = """<robot name="arm"><link name="base"/><link name="arm"><inertial><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<collision><geometry><mesh filename="{}"/></geometry></collision></link>
<joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>
</robot>"""
BODY = '<body><joint name="j"/><geom size="1" mass="1"/></body>'
XACRO = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">{}<link name="base"/></robot>'


@pytest.fixture
def place(tmp_path):
    """A folder for descriptions, beside one with files that they should not read."""
    for name in ("own", "own/meshes", "secret"):
        (tmp_path / name).mkdir()
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *CORNERS[list(face)].ravel(), 0) for face in FACES)
    for name in ("own/meshes/arm.stl", "secret/arm.stl"):
        (tmp_path / name).write_bytes(bytes(80) + struct.pack("<I", len(FACES)) + facets)
    (tmp_path / "secret" / "part.xml").write_text(f"<mujoco><worldbody>{BODY}</worldbody></mujoco>")
    (tmp_path / "secret" / "part.xacro").write_text(XACRO.format(""))
    (tmp_path / "secret" / "values.yaml").write_text("secret: 1")
    (tmp_path / "own" / "link.stl").symlink_to(tmp_path / "secret" / "arm.stl")
    (tmp_path / "own" / "link.xml").symlink_to(tmp_path / "secret" / "part.xml")
    (tmp_path / "own" / "link.xacro").symlink_to(tmp_path / "secret" / "part.xacro")
    return tmp_path


def outside(place, endings):
    return [*(f"../secret/{one}" for one in endings), *(f"{place}/secret/{one}" for one in endings)]


def test_meshes_of_a_urdf_stay_inside(place, monkeypatch):
    urdf = place / "own" / "arm.urdf"
    urdf.write_text(URDF.format("meshes/arm.stl"))
    assert read_geometry(urdf).ngeoms == 1
    names = [*outside(place, ["arm.stl"]), f"file://{place}/secret/arm.stl", "link.stl", "meshes/../link.stl"]
    names += ["package://secret/arm.stl", "package://own/../secret/arm.stl", "package:///secret/arm.stl"]
    for name in names:
        urdf.write_text(URDF.format(name))
        with pytest.raises(
            RobotError, match="outside of the folder of the description. Put it there"
        ) as caught:
            read_geometry(urdf)
        assert str(caught.value).endswith(f"in the environment variable {VARIABLE}")
        assert read_geometry(urdf, [place / "secret"]).ngeoms == 1
    monkeypatch.setenv(VARIABLE, f"/nowhere:{place / 'secret'}")
    assert read_geometry(urdf).ngeoms == 1


def test_meshes_lie_beside_a_folder_of_descriptions_with_a_usual_name(place):
    (place / "own" / "urdf").mkdir()
    file = place / "own" / "urdf" / "arm.urdf"
    file.write_text(URDF.format("../meshes/arm.stl"))
    assert len(read_geometry(file).geometryObjects) == 1
    file.write_text(URDF.format("../../secret/arm.stl"))
    with pytest.raises(RobotError, match="outside of the folder of the description"):
        read_geometry(file)


def test_a_package_is_one_folder(place):
    (place / "package.xml").touch()
    urdf = place / "own" / "arm.urdf"
    for name in ("../secret/arm.stl", "package://secret/arm.stl"):
        urdf.write_text(URDF.format(name))
        assert read_geometry(urdf).ngeoms == 1


def test_links_in_a_stated_folder_are_followed(place):
    """As `colcon build --symlink-install` makes them."""
    urdf = place / "secret" / "arm.urdf"
    urdf.write_text(URDF.format("package://own/link2.stl"))
    (place / "elsewhere.stl").write_bytes((place / "own" / "meshes" / "arm.stl").read_bytes())
    (place / "own" / "link2.stl").symlink_to(place / "elsewhere.stl")
    assert read_geometry(urdf, [place]).ngeoms == 1
    assert read_geometry(urdf, [place / "own"]).ngeoms == 1


def test_files_of_an_mjcf_stay_inside(place, monkeypatch):
    pytest.importorskip("mujoco")
    mjcf = place / "own" / "arm.xml"
    for name in [*outside(place, ["part.xml"]), "link.xml"]:
        text = f'<mujoco><include file="{name}"/></mujoco>'
        mjcf.write_text(text)
        for source in ((mjcf,), (text, str(mjcf.parent))):
            with pytest.raises(RobotError, match="outside of the folder of the description"):
                compile_mjcf(*source)
    mesh = '<mujoco>{}<asset><mesh name="m" file="{}"/></asset><worldbody>{}<geom type="mesh" mesh="m"/>'
    mesh += "</worldbody></mujoco>"
    for compiler, name in (
        *(("", name) for name in [*outside(place, ["arm.stl"]), "link.stl"]),
        ('<compiler meshdir="../secret"/>', "arm.stl"),
        (f'<compiler assetdir="{place}/secret"/>', "arm.stl"),
        ('<compiler strippath="true" meshdir="../secret"/>', "some/arm.stl"),
    ):
        mjcf.write_text(mesh.format(compiler, name, BODY))
        with pytest.raises(RobotError, match="outside of the folder of the description"):
            compile_mjcf(mjcf)
    mjcf.write_text(mesh.format('<compiler meshdir="meshes"/>', "arm.stl", BODY))
    assert compile_mjcf(mjcf).nmesh == 1
    mjcf.write_text('<mujoco><include file="../secret/part.xml"/></mujoco>')
    monkeypatch.setenv(VARIABLE, str(place / "secret"))
    assert compile_mjcf(mjcf).njnt == 1


def test_an_mjcf_that_includes_itself_is_refused(place):
    pytest.importorskip("mujoco")
    mjcf = place / "own" / "arm.xml"
    mjcf.write_text('<mujoco><include file="b.xml"/></mujoco>')
    (place / "own" / "b.xml").write_text('<mujoco><include file="arm.xml"/></mujoco>')
    with pytest.raises(BrokenTree, match="MuJoCo"):
        compile_mjcf(mjcf)


@pytest.mark.parametrize(
    "content",
    [
        '<xacro:include filename="../secret/part.xacro"/>',
        '<xacro:include filename="{secret}/part.xacro"/>',
        '<xacro:include filename="link.xacro"/>',
        """<xacro:property name="v" value="${{xacro.load_yaml('../secret/values.yaml')}}"/><a b="${{v}}"/>""",
    ],
)
def test_macros_read_only_what_is_inside(place, monkeypatch, content):
    pytest.importorskip("xacro")
    path = place / "own" / "arm.xacro"
    path.write_text(XACRO.format(content.format(secret=place / "secret")))
    with pytest.raises(RobotError, match="outside of the folder of the description"):
        read_urdf(path)
    monkeypatch.setenv(VARIABLE, str(place / "secret"))
    assert "base" in read_urdf(path)


ENDLESS = """<xacro:macro name="m" params="n"><xacro:if value="${n > 0}"><xacro:m n="${n - 1}"/>
<xacro:m n="${n - 1}"/></xacro:if><l/></xacro:macro><xacro:m n="60"/>"""


@pytest.mark.parametrize(
    ("content", "seconds", "message"),
    [
        (ENDLESS, 2.0, r"xacro (took more than 2 s|needs more than)"),
        ('<a b="${9 ** 9 ** 9}"/>', 2.0, r"xacro took more than 2 s"),
        ("<a b=\"${len('x' * 10 ** 10)}\"/>", 600.0, r"xacro needs more than 500 MB"),
        ('<a b="${[0] * 10 ** 10}"/>', 600.0, r"xacro needs more than 500 MB"),
    ],
)
def test_macros_without_an_end_are_ended(place, monkeypatch, content, seconds, message):
    pytest.importorskip("xacro")
    monkeypatch.setattr(xacro_macros, "SECONDS", seconds)
    path = place / "own" / "arm.xacro"
    path.write_text(XACRO.format(content))
    with pytest.raises(BrokenTree, match=message) as caught:
        read_urdf(path)
    assert "\n" not in str(caught.value)
