"""Whether what MuJoCo makes of an MJCF is the arm that is meant."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..effects.rigid_body import inertial_parameters
from ..errors import RobotError
from ..model import Model
from ..robot_files.mjcf import mjcf_kinematics
from ..robot_files.robot_file import described_model
from .mjcf_changes import SAME, TERMS, sizes
from .portable import Portable


class Remedy(NamedTuple):
    """What an error says after the number that differs."""

    of_joint: str
    of_body: str


WRITTEN = Remedy(
    ", whatever its element says. Take away what overrides it, such as springdamper",
    ", whatever its <inertial> says. Take away what overrides it, such as inertiafromgeom, settotalmass or "
    "balanceinertia",
)
"""Where the numbers have just been written."""


def described(compiled: Any, portable: Portable, where: str) -> Model:
    """What the file describes, the same joints held.

    Raises:
        RobotError: Joints are elsewhere than in the robot.
    """
    robot = portable.robot
    kinematics = mjcf_kinematics(compiled, where, robot.joints)
    mine, theirs = robot.kinematics, kinematics.model
    for joint, name in enumerate(robot.joints, start=1):
        same = theirs.names[joint] == name and mine.parents[joint] == theirs.parents[joint]
        if not same or not theirs.jointPlacements[joint].isApprox(mine.jointPlacements[joint], SAME):
            raise RobotError(
                f"{where}: joint '{name}' is not where the model has it; give the file that its robot is from"
            )
    return described_model(robot.name, kinematics)


def taken(portable: Portable) -> tuple[Portable, list[str]]:
    """The model as far as MuJoCo takes it, no friction or rotor below zero; and what was, in sentences."""
    joints, remarks = portable.joints, []
    for name, (attribute, _) in list(TERMS.items())[:3]:
        values = getattr(joints, name)
        remarks += [
            f"{attribute} of {joint} was found to be {value:.3g}, which nothing has: 0 is written"
            for joint, value in zip(portable.robot.joints, values, strict=True)
            if value < 0.0
        ]
        joints = replace(joints, **{name: np.maximum(values, 0.0)})
    return replace(portable, joints=joints), remarks


def require_same(wanted: Portable, model: Model, where: str, remedy: Remedy = WRITTEN) -> None:
    """Compare what MuJoCo makes of the new text with what was meant.

    Raises:
        RobotError: It makes something else, as of what a compiler option overrides.
    """
    made, robot = Portable.of(model), wanted.robot
    for place, name in enumerate(robot.joints):
        for term, (attribute, _) in TERMS.items():
            one, other = getattr(made.joints, term)[place], getattr(wanted.joints, term)[place]
            if abs(one - other) > SAME * max(abs(one), abs(other)):
                raise RobotError(
                    f"{where}: {attribute} of joint '{name}' is {one:.4g} in MuJoCo, not {other:.4g}"
                    f"{remedy.of_joint}"
                )
        one, other = (inertial_parameters(arm.kinematics.inertias[place + 1]) for arm in (model.robot, robot))
        if np.any(np.abs(one - other) > 10.0 * SAME * sizes(other)):
            raise RobotError(
                f"{where}: the body behind joint '{name}' is another one in MuJoCo{remedy.of_body}"
            )
