"""Patch of a URDF: the arm of the new text is the identified one, and nothing else changes."""

import re
from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.errors import RobotError
from exidyn.identification.export import Portable
from exidyn.identification.export.urdf_patch import patch_urdf
from exidyn.identification.fit.identified import Standard
from exidyn.identification.robot_files.robot_file import described_model
from exidyn.identification.robot_files.urdf import parse_urdf

ARM = """<?xml version="1.0"?>
<robot name="arm">  <!-- measured by hand -->
  <link name="base"><visual><geometry><mesh filename="package://arm/base.stl"/></geometry></visual></link>
  <link name="upper">
    <inertial><origin rpy="0 0 1.57079632679" xyz="0.1 0 0"/><mass value="2.0"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial>
  </link>
  <link name="tool"><inertial><mass value='0.5'/><inertia ixx="1e-3"
    iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="hand"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="9" velocity="2"/><dynamics damping="0.3" friction="0.1"/></joint>
  <joint name="mount" type="fixed"><parent link="upper"/><child link="tool"/><origin xyz="0.2 0 0"/></joint>
  <joint name="wrist" type="continuous"><parent link="tool"/><child link="hand"/><axis xyz="1 0 0"/></joint>
</robot>
"""


def identified(change) -> tuple[Portable, Standard]:
    """The arm with other parameters, each with a standard deviation of 0.01."""
    model = described_model("arm", parse_urdf(ARM))
    values = model.nominal_values
    values[[model.names.index(name) for name in ("Fv1", "Fc1")]] = 0.3, 0.1
    values[:20] += change
    return Portable.of(model.at(values)), Standard(values, 1e-4 * np.eye(len(values)))


def body(mass: float, center: float) -> np.ndarray:
    """Ten parameters of a small ball on the x axis."""
    square = mass * center**2
    return np.array([1e-3, 0, 0, 1e-3 + square, 0, 1e-3 + square, mass * center, 0, 0, mass])


def test_what_is_not_changed_stays_to_the_byte() -> None:
    patched = patch_urdf(
        *identified(np.concatenate([np.zeros(10), body(0.7, 0.05)])), ARM.encode(), "arm.urdf"
    )
    text = patched.text.decode()
    assert re.sub(r'<inertial><origin xyz="0.05 0 0"/>.*?</inertial>', "", text) == ARM.replace(
        '<link name="hand"/>', '<link name="hand"></link>'
    )


def test_the_patched_arm_is_the_identified_one() -> None:
    change = np.concatenate([body(0.4, 0.3), body(0.7, 0.05)])
    portable, standard = identified(change)
    damped = replace(portable.joints, damping=np.array([0.25, 0.0]))
    patched = patch_urdf(replace(portable, joints=damped), standard, ARM.encode(), "arm.urdf")
    read = parse_urdf(patched.text.decode()).model
    for place, wanted in enumerate(list(portable.robot.kinematics.inertias)[1:], start=1):
        np.testing.assert_allclose(
            read.inertias[place].toDynamicParameters(), wanted.toDynamicParameters(), atol=1e-7
        )
    text = patched.text.decode()
    for kept in (
        "measured by hand",
        "package://arm/base.stl",
        "<mass value='0.5'/>",
        'damping="0.25" friction="0.1"',
    ):
        assert kept in text
    [mass] = [c for c in patched.changes if (c.where, c.attribute) == ("link 'upper'", "mass")]
    assert (mass.old, mass.new) == (2.0, pytest.approx(2.4))
    assert mass.half == pytest.approx(0.0196, rel=1e-3)


@pytest.mark.parametrize(
    ("change", "text", "words"),
    [
        (np.zeros(20), ARM.replace('"wrist"', '"roll"'), "has no joint wrist; it describes another arm"),
        (np.concatenate([-body(2.2, 0.1), body(1.0, 0.0)]), ARM, "links fixed to 'upper' weigh more"),
    ],
)
def test_another_arm_and_links_that_weigh_too_much_are_refused(change, text, words) -> None:
    with pytest.raises(RobotError, match=words):
        patch_urdf(*identified(change), text.encode(), "arm.urdf")
