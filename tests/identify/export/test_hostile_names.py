"""Exports of an arm whose names are code: every format parses, holds the names, and runs nothing."""

import json
import tomllib
from xml.etree import ElementTree

import mujoco
import pytest

from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.robot_files.commented import commented_text
from exidyn.identification.robot_files.robot_file import parse_model
from exidyn.quoting import one_line

from ...parts.runs.simulated import known
from ...parts.small.hostile_names import NAMES, model, values


@pytest.fixture(params=NAMES, ids=range(len(NAMES)))
def arm(request):
    of = model(request.param)
    return Portable.of(known(of, values(of)))


def text_of(name, arm):
    """What is written; it can be encoded."""
    text = FORMATS[name].text(arm)
    FORMATS[name].leaves_out(arm)
    return text.encode().decode()


@pytest.mark.parametrize("name", ["urdf", "mjcf"])
def test_xml_holds_the_names(arm, name):
    root = ElementTree.fromstring(text_of(name, arm))
    joints = [joint.get("name") for joint in root.iter("joint") if joint.get("type") != "fixed"]
    expected = [one_line(joint) for joint in arm.robot.joints]
    assert [joint for joint in joints if joint in expected] == expected
    assert root.get("model" if name == "mjcf" else "name") == one_line(arm.robot.name)
    assert len(list(root.iter("dynamics"))) == (0 if name == "mjcf" else 2)


def test_mjcf_and_json_hold_the_names(arm):
    compiled = mujoco.MjModel.from_xml_string(text_of("mjcf", arm))
    assert [compiled.joint(k).name for k in range(2)] == [one_line(joint) for joint in arm.robot.joints]
    table = json.loads(text_of("json", arm))
    assert table["robot"] == arm.robot.name
    assert [joint["name"] for joint in table["joints"]] == list(arm.robot.joints)


def test_toml_holds_the_names(arm):
    for text in (text_of("toml", arm), commented_text(arm.model)):
        table = tomllib.loads(text)
        assert table["name"] == arm.robot.name
        assert [link["joint"] for link in table["link"]] == list(arm.robot.joints)
    of = model(NAMES[3])
    assert parse_model(FORMATS["toml"].text(Portable.of(of))).robot.joints == of.robot.joints
