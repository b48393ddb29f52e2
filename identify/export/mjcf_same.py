"""Check that the model compiled from an MJCF equals the intended model."""

from dataclasses import replace
from typing import Any

import numpy as np

from ..arm.robot import Held, Robot
from ..effects.rigid_body import inertial_parameters
from ..errors import RobotError
from ..model import Model
from ..robot_files.mjcf import mjcf_kinematics
from ..robot_files.mjcf_names import joint_name
from ..robot_files.robot_file import described_model
from .mjcf_changes import SAME, TERMS, nearly_equal, sizes
from .portable import Portable

WRITTEN = (
    ", which differs from its element. Remove what overrides it, such as springdamper",
    ", which differs from its <inertial>. Remove what overrides it, such as inertiafromgeom, settotalmass or "
    "balanceinertia",
)
"""Ends of errors about a number of a joint and about a body that differ after the numbers were written."""


def described(compiled: Any, portable: Portable, where: str) -> Model:
    """Model that the file describes, with the same held joints; raises `RobotError` for another arm."""
    robot = portable.robot
    kinematics = mjcf_kinematics(compiled, where, robot.joints, held_in(compiled, robot))
    mine, theirs = robot.kinematics, kinematics.model
    for joint, name in enumerate(robot.joints, start=1):
        matches = theirs.names[joint] == name and mine.parents[joint] == theirs.parents[joint]
        if not matches or not theirs.jointPlacements[joint].isApprox(mine.jointPlacements[joint], SAME):
            raise RobotError(
                f"{where}: joint '{name}' is at another place than in the model; give the MJCF of its robot"
            )
    return described_model(robot.name, kinematics)


def held_in(compiled: Any, robot: Robot) -> Held:
    """Held joints of a robot that the file has; those of a URDF may be fixed in an MJCF of the same arm."""
    names = [joint_name(compiled, joint) for joint in range(compiled.njnt)]
    return {name: position for name, position in robot.held.items() if name in names}


def accepted(portable: Portable) -> tuple[Portable, list[str]]:
    """Model that MuJoCo accepts, without negative friction or rotor inertia; and sentences on changes."""
    joints, remarks = portable.joints, []
    for name, (attribute, _) in list(TERMS.items())[:3]:
        values = getattr(joints, name)
        remarks += [
            f"{attribute} of {joint} was identified as {value:.3g}, which is impossible: 0 is written"
            for joint, value in zip(portable.robot.joints, values, strict=True)
            if value < 0.0
        ]
        joints = replace(joints, **{name: np.maximum(values, 0.0)})
    return replace(portable, joints=joints), remarks


def require_same(wanted: Portable, model: Model, where: str, remedies: tuple[str, str] = WRITTEN) -> None:
    """Raise `RobotError` unless the model compiled from the new text equals the intended model."""
    made, robot = Portable.of(model), wanted.robot
    for place, name in enumerate(robot.joints):
        for term, (attribute, _) in TERMS.items():
            actual, expected = getattr(made.joints, term)[place], getattr(wanted.joints, term)[place]
            if not nearly_equal(actual, expected):
                raise RobotError(
                    f"{where}: {attribute} of joint '{name}' is {actual:.4g} in MuJoCo, not {expected:.4g}"
                    f"{remedies[0]}"
                )
        body, intended = (
            inertial_parameters(arm.kinematics.inertias[place + 1]) for arm in (model.robot, robot)
        )
        if np.any(np.abs(body - intended) > 10.0 * SAME * sizes(intended)):
            raise RobotError(f"{where}: MuJoCo has another body behind joint '{name}'{remedies[1]}")
