"""Patch: the user's own MJCF with what was found in it, and every other byte as it was.

What MuJoCo makes of the new text is compared with the model before it is handed out.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..effects.rigid_body import inertial_parameters
from ..errors import RobotError
from ..fit.identified import Standard
from ..model import Model
from ..robot_files.mjcf import body_parts, compile_mjcf, mjcf_kinematics
from ..robot_files.mjcf_names import joint_name
from ..robot_files.robot_file import described_model
from .mjcf_changes import SAME, TERMS, Change, File, body_changes, change_gravity, joint_changes, sizes
from .mjcf_elements import Elements
from .portable import Portable, left_out
from .spread import Spread
from .xml_text import Edits, read_tags

FEATURES = ("gravity", "armature", "damping", "dry", "stiffness", "uncertainty")


@dataclass(frozen=True)
class Patch:
    """A new text of an MJCF.

    Attributes:
        text: With the changes.
        changes: Numbers that are others now.
        left: What MJCF cannot hold, a sentence each.
    """

    text: bytes
    changes: tuple[Change, ...]
    left: tuple[str, ...]


def patch(portable: Portable, found: Standard, text: bytes, folder: str, where: str) -> Patch:
    """Write what was found into an MJCF.

    Args:
        portable: The model, without a payload in its last link.
        found: Its parameters, of which intervals are made.
        text: Of the MJCF that the robot is from.
        folder: In which its meshes lie.
        where: What errors call it.

    Raises:
        RobotError: It is of another arm, or cannot hold what was found.
    """
    file = _read(portable, text, folder, where)
    taken, below = _taken(portable)
    spread, edits = Spread(portable.model, found), Edits(text)
    changes = [
        *joint_changes(file, taken, spread, edits), *body_changes(file, taken, spread, edits),
    ]  # fmt: skip
    gravity = change_gravity(file, taken, edits)
    new = edits.text()
    _check(taken, _described(compile_mjcf(new.decode(), folder), taken, where), where)
    return Patch(new, tuple(changes), (*below, *gravity, *_left(taken, spread)))


def _read(portable: Portable, text: bytes, folder: str, where: str) -> File:
    try:
        root, compiled = read_tags(text, where), compile_mjcf(text.decode(), folder)
    except UnicodeDecodeError as error:
        raise RobotError(f"{where}: not UTF-8; write it as UTF-8") from error
    elements = Elements(root, compiled, where)
    every, joints = [joint_name(compiled, joint) for joint in range(compiled.njnt)], portable.robot.joints
    if missing := [joint for joint in joints if joint not in every]:
        raise RobotError(f"{where} has no joint {', '.join(missing)}; it is of another arm")
    nominal = _described(compiled, portable, where)
    parts = body_parts(compiled, joints, {}, where)
    return File(where, elements, compiled, [every.index(joint) for joint in joints], parts, nominal)


def _described(compiled: Any, portable: Portable, where: str) -> Model:
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


def _taken(portable: Portable) -> tuple[Portable, list[str]]:
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


def _left(portable: Portable, spread: Spread) -> list[str]:
    """What MJCF cannot hold; of constant torques those that are told apart from none."""
    joints = portable.joints
    halves = np.array([spread.half(place, "constant") for place in range(portable.robot.dof)])
    alone = np.where((joints.stiffness != 0.0) | (np.abs(joints.constant) <= halves), 0.0, joints.constant)
    return left_out(replace(portable, joints=replace(joints, constant=alone)), FEATURES)


def _check(wanted: Portable, model: Model, where: str) -> None:
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
                    f"{where}: {attribute} of joint '{name}' is {one:.4g} in MuJoCo, not {other:.4g}, "
                    "whatever its element says. Take away what overrides it, such as springdamper"
                )
        one, other = (inertial_parameters(arm.kinematics.inertias[place + 1]) for arm in (model.robot, robot))
        if np.any(np.abs(one - other) > 10.0 * SAME * sizes(other)):
            raise RobotError(
                f"{where}: the body behind joint '{name}' is another one in MuJoCo, whatever its <inertial> "
                "says. Take away what overrides it, such as inertiafromgeom, settotalmass or balanceinertia"
            )
