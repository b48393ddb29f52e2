"""Patch of the user's MJCF: identified numbers are written, and every other byte stays the same.

The model that MuJoCo compiles from the new text is compared with the identified model before it is returned.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..arm.robot import Held, Robot
from ..errors import RobotError
from ..fit.identified import Standard
from ..model import Model
from ..robot_files.mjcf import body_parts, compile_mjcf, mjcf_kinematics
from ..robot_files.mjcf_drives import servos
from ..robot_files.mjcf_elements import JOINT_TERMS, joint_names
from ..robot_files.robot_file import described_model
from .bodies import robot_bodies, sizes
from .changes import SAME, Change, Spread, nearly_equal
from .left_out import left_out
from .mjcf_changes import File, body_changes, change_gravity, gravcomp_changes, joint_changes
from .mjcf_dcmotors import kept_cogging, require_motors, write_motors
from .mjcf_servos import altered_damping, keep_damping, require_servos, servo_changes, written_servos
from .portable import Portable
from .xml_text import Edits, Elements, read_tags

FEATURES = ("bodies", "gravity", "armature", "damping", "dry", "stiffness", "uncertainty")
WRITTEN = (
    ", which differs from its element. Remove what overrides it, such as springdamper",
    ", which differs from its <inertial>. Remove what overrides it, such as inertiafromgeom, settotalmass or "
    "balanceinertia",
)
"""Ends of errors about a number of a joint and about a body that differ after the numbers were written."""


@dataclass(frozen=True)
class Patch:
    """New text of an MJCF."""

    text: bytes  # text with the changes
    changes: tuple[Change, ...]  # changed numbers
    left_out: tuple[str, ...]  # one sentence for each part of the model that MJCF cannot represent


def patch(
    portable: Portable,
    standard: Standard,
    text: bytes,
    folder: str,
    where: str,
    elsewhere: Collection[str] = (),
) -> Patch:
    """Write the identified numbers to the text of an MJCF that describes the robot.

    The model has no payload in its last link, and its standard parameters give the intervals. `folder` is
    that of the meshes, and `where` the name of the file in errors. The caller states the features `elsewhere`
    itself, by their names in `left_out`. Raises `RobotError` if the file describes another arm, or cannot
    represent the identified numbers.
    """
    file = _read(portable, text, folder, where)
    wanted, below = accepted(portable)
    spread, edits = Spread(portable.model, standard), Edits(text)
    of_motors, motors, unwritten = write_motors(file, wanted, spread, edits)
    changes = [
        *joint_changes(file, unwritten, spread, edits), *of_motors,
        *body_changes(file, wanted, spread, edits), *servo_changes(file, wanted, edits),
        *gravcomp_changes(file, wanted, edits),
    ]  # fmt: skip
    gravity, unchanged = change_gravity(file, wanted, edits)
    changes += gravity
    written = written_servos(file.compiled, wanted.robot)
    changes += keep_damping(file, compile_mjcf(edits.text().decode(), folder), written, edits)
    new = edits.text()
    compiled = compile_mjcf(new.decode(), folder)
    require_same(wanted, described(compiled, wanted, where), where)
    require_servos(compiled, wanted.robot, where)
    require_motors(compiled, motors, where)
    altered = altered_damping(file.compiled, compiled, written)
    has_servos = bool(servos(compiled, wanted.robot.joints))
    features = (*FEATURES, *elsewhere, *(("servos",) if has_servos else ()))
    missing = sentences_left_out(unwritten, spread, features)
    return Patch(new, tuple(changes), (*below, *unchanged, *altered, *kept_cogging(file, wanted), *missing))


def _read(portable: Portable, text: bytes, folder: str, where: str) -> File:
    try:
        root, compiled = read_tags(text, where), compile_mjcf(text.decode(), folder)
    except UnicodeDecodeError as error:
        raise RobotError(f"{where}: not UTF-8; write it as UTF-8") from error
    elements = Elements(root, compiled, where)
    names, joints = joint_names(compiled), portable.robot.joints
    if missing := [joint for joint in joints if joint not in names]:
        raise RobotError(f"{where} has no joint {', '.join(missing)}; it describes another arm")
    nominal = described(compiled, portable, where)
    parts = body_parts(compiled, joints, held_in(compiled, portable.robot), where)
    return File(where, elements, compiled, [names.index(joint) for joint in joints], parts, nominal)


def sentences_left_out(portable: Portable, spread: Spread, features: Collection[str]) -> list[str]:
    """Sentences on what the file cannot represent; constant torques only if they differ from zero."""
    joints = portable.joints
    halves = np.array([spread.half(place, "constant") for place in range(portable.robot.dof)])
    alone = np.where(np.abs(joints.constant) <= halves, 0.0, joints.constant)
    return left_out(replace(portable, joints=replace(joints, constant=alone)), features)


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
    names = joint_names(compiled)
    return {name: position for name, position in robot.held.items() if name in names}


def accepted(portable: Portable) -> tuple[Portable, list[str]]:
    """Model that MuJoCo accepts, without negative friction or rotor inertia; and sentences on changes."""
    joints, remarks = portable.joints, []
    for term in ("armature", "damping", "dry"):
        values = getattr(joints, term)
        remarks += [
            f"{JOINT_TERMS[term].attribute} of {joint} was identified as {value:.3g}, which is impossible: "
            "0 is written"
            for joint, value in zip(portable.robot.joints, values, strict=True)
            if value < 0.0
        ]
        joints = replace(joints, **{term: np.maximum(values, 0.0)})
    return replace(portable, joints=joints), remarks


def require_same(wanted: Portable, model: Model, where: str, remedies: tuple[str, str] = WRITTEN) -> None:
    """Raise `RobotError` unless the model compiled from the new text equals the intended model."""
    made, robot = Portable.of(model), wanted.robot
    bodies = zip(robot.joints, robot_bodies(model.robot), robot_bodies(robot), strict=True)
    for place, (name, body, intended) in enumerate(bodies):
        for term, number in JOINT_TERMS.items():
            actual, expected = getattr(made.joints, term)[place], getattr(wanted.joints, term)[place]
            if not nearly_equal(actual, expected):
                raise RobotError(
                    f"{where}: {number.attribute} of joint '{name}' is {actual:.4g} in MuJoCo, not "
                    f"{expected:.4g}{remedies[0]}"
                )
        if np.any(np.abs(body - intended) > 10.0 * SAME * sizes(intended)):
            raise RobotError(f"{where}: MuJoCo has another body behind joint '{name}'{remedies[1]}")
