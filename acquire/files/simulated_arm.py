"""The arm of a simulation's MJCF as recordings describe it: joints, drives, mounting and held joints."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.robot import Robot
from exidyn.identification.errors import RobotError
from exidyn.identification.export.mjcf_servos import with_controller
from exidyn.identification.in_mujoco.trial import Source
from exidyn.identification.model import Model
from exidyn.identification.recordings.importers import IMPORTERS, import_source, kind_of
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.mjcf import movable_mjcf_joints
from exidyn.identification.robot_files.robot_file import read_model

STATED = (
    "drive_gain", "drive_gain_tolerance", "gear_ratio", "servo", "direct_drive", "passive",
    "inertial_tolerance", "inertias_stated",
)  # fmt: skip
"""Fields of the recorded robot that an MJCF does not have."""
SAME_PLACE = 1e-4
"""Relative difference of the placements of joints within which two descriptions have the same base."""


def import_runs(arm: Path, paths: Sequence[Path]) -> list[list[Recording]]:
    """Recordings in each file. Logs that do not contain their robot are read with all joints of the MJCF.

    Raises:
        RobotError: Such a log needs a model of all joints, which is impossible for this MJCF.
    """
    model = None
    if any(not path.exists() or not IMPORTERS[kind_of(path)].robot for path in paths):
        model = read_model(arm)
    return [import_source(path, model) for path in paths]


def simulated_arm(arm: Path, recorded: Robot) -> Model:
    """Model of an MJCF with the joints of a recorded robot; the others are held where that robot holds them.

    Raises:
        RobotError: The file lacks a joint, or has forces on the joints that no model can represent.
    """
    names = {name for joints in movable_mjcf_joints(arm) for name in joints}
    held = {name: position for name, position in recorded.held.items() if name in names}
    model = read_model(arm, recorded.joints, held)
    robot = replace(model.robot, **{name: getattr(recorded, name) for name in STATED})
    return replace(model, robot=_mounted(robot, recorded))


def controlled(source: Source, robot: Robot, kp: Sequence[float], kd: Sequence[float]) -> Source:
    """The file with servos of these gains in place of its motors.

    `kp` is the torque per position error [N m/rad] and `kd` that against the velocity [N m s/rad], one number
    or one per joint.

    Raises:
        RobotError: A gain or their count is wrong, or a joint does not have exactly one motor.
    """
    gains = _per_joint(robot, kp, "--kp"), _per_joint(robot, kd, "--kd")
    return source._replace(
        text=with_controller(source.text, source.folder, source.where, robot.joints, *gains)
    )


def _per_joint(robot: Robot, values: Sequence[float], option: str) -> np.ndarray:
    if len(values) not in (1, robot.dof):
        raise RobotError(
            f"{option}: {len(values)} numbers for {robot.dof} joints ({', '.join(robot.joints)}); give one "
            "for all joints, or one per joint"
        )
    for value in values:
        if not 0.0 <= value < np.inf:
            raise RobotError(f"{option}: {value:g}; a gain is a finite number of at least 0")
    return np.full(robot.dof, values, float)


def _mounted(robot: Robot, recorded: Robot) -> Robot:
    """The robot with the recorded gravity, if both descriptions have the same base."""
    pairs = zip(robot.kinematics.jointPlacements, recorded.kinematics.jointPlacements, strict=True)
    alike = all(mine.isApprox(other, SAME_PLACE) for mine, other in pairs)
    if not alike or np.array_equal(robot.gravity, recorded.gravity):
        return robot
    kinematics = robot.kinematics.copy()
    kinematics.gravity = pin.Motion(recorded.gravity, np.zeros(3))
    return replace(robot, kinematics=kinematics)
