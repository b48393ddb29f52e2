"""Hints on options: each that is printed makes the log readable, and none is printed that does not."""

import re
import shlex
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.acquire.command_line import main
from exidyn.identification.arm.robot import Robot
from exidyn.identification.effects import RigidBody
from exidyn.identification.errors import BadTime, BadUnit, WrongShape
from exidyn.identification.model import Model
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.robot_files.robot_file import urdf_text

from ...parts.runs.runs import model, noise

TIME = 0.01 * np.arange(300)
MOTION = np.column_stack([1.2 * np.sin(2.0 * TIME), 0.8 * np.cos(3.0 * TIME)])


def rail(last: bool) -> Model:
    """An arm of a revolute and a prismatic joint, the last or the first."""
    kinematics = pin.Model()
    joints = [pin.JointModelRZ(), pin.JointModelPX()]
    for place, joint in enumerate(joints if last else joints[::-1]):
        index = kinematics.addJoint(place, joint, pin.SE3.Identity(), f"axis{place + 1}")
        kinematics.appendBodyToJoint(index, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    return Model(Robot("cell", kinematics), (RigidBody(),))


def write(path, time, position):
    rows = np.column_stack([time, position, noise()[:1].repeat(len(time), axis=0) + 0.1 * position])
    np.savetxt(path, rows, "%.9g", ",", header="t,q1,q2,tau1,tau2", comments="")
    return path


@pytest.mark.parametrize(
    ("arm", "scale", "second", "option"),
    [
        (model(), [180 / np.pi] * 2, 1.0, "--degrees"),
        (model(), [1.0] * 2, 1e3, "--units time=ms"),
        (model(), [180 / np.pi] * 2, 1e3, "--degrees --units time=ms"),
        (rail(last=True), [180 / np.pi, 1e3], 1.0, "--units position=deg,mm"),
        (rail(last=False), [1e3, 180 / np.pi], 1.0, "--units position=mm,deg"),
        (rail(last=False), [1e3, 1.0], 1.0, "--units position=mm,rad"),
        (rail(last=False), [1.0, 180 / np.pi], 1.0, "--degrees"),
    ],
)
def test_the_hint_makes_the_log_readable(tmp_path, arm, scale, second, option, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "run.csv", second * TIME, MOTION * scale)
    with pytest.raises(
        BadUnit, match=rf"It looks like .*: exidyn import {re.escape(option)} \(in Python"
    ) as error:
        import_source(tmp_path / "run.csv", arm)
    hint = re.search(r"exidyn import (.*?) \(in Python", str(error.value))[1]
    (tmp_path / "arm.urdf").write_text(urdf_text(arm))
    assert main(["import", "run.csv", "--robot", "arm.urdf", "-o", "run.mcap", *shlex.split(hint)]) == 0


def with_limits() -> Model:
    """The small arm with limits, so that positions may be percent of its travel."""
    arm = model()
    limits = replace(arm.robot.limits, position_lower=np.full(2, -3.0), position_upper=np.full(2, 3.0))
    return replace(arm, robot=replace(arm.robot, limits=limits))


@pytest.mark.parametrize("arm", [model(), with_limits(), rail(last=True)])
@pytest.mark.parametrize("count", [10, 60])
def test_poses_are_no_motion_in_milliseconds(tmp_path, arm, count):
    path = write(tmp_path / "poses.csv", 5.0 * np.arange(count), MOTION[:: len(MOTION) // count])
    with pytest.raises(BadUnit, match=r"at most 0\.5 s can be followed.*single poses are no motion") as error:
        import_source(path, arm)
    assert "--" not in str(error.value)


@pytest.mark.parametrize(
    ("time", "words"),
    [
        (np.float32(1.7e9 + TIME), "All times are equal, .*: exidyn import --rate HZ"),
        (np.where(TIME < 0.02, 0.5, TIME), "Leave out the first 2 rows"),
    ],
)
def test_hints_on_time(tmp_path, time, words):
    path = write(tmp_path / "run.csv", time, MOTION)
    with pytest.raises(BadTime, match=words):
        import_source(path, model())
    if "--rate" in words:
        assert len(import_source(path, model(), rate=100.0)) == 1


def test_no_column_is_to_be_named_as_time_if_none_increases(tmp_path):
    np.savez(tmp_path / "run.npz", q=MOTION, tau=0.1 * MOTION)
    with pytest.raises(WrongShape, match="no column of time") as error:
        import_source(tmp_path / "run.npz", model())
    assert "--columns" not in str(error.value)
    assert "--rate HZ" in str(error.value)
