"""Patch of the user's MJCF: identified numbers are written, and every other byte stays the same.

The model that MuJoCo compiles from the new text is compared with the identified model before it is returned.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from ..errors import RobotError
from ..fit.identified import Standard
from ..robot_files.mjcf import body_parts, compile_mjcf
from ..robot_files.mjcf_drives import servos
from ..robot_files.mjcf_names import joint_name
from .left_out import left_out
from .mjcf_bodies import body_changes
from .mjcf_changes import Change, File, change_gravity, gravcomp_changes, joint_changes
from .mjcf_dcmotors import kept_cogging, require_motors, write_motors
from .mjcf_same import accepted, described, held_in, require_same
from .mjcf_servos import altered_damping, keep_damping, require_servos, servo_changes, written_servos
from .portable import Portable
from .spread import Spread
from .xml_text import Edits, Elements, read_tags

FEATURES = ("bodies", "gravity", "armature", "damping", "dry", "stiffness", "uncertainty")


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
    """Write the identified numbers to an MJCF.

    Args:
        portable: Identified model, without a payload in its last link.
        standard: Standard parameters of the model, for intervals.
        text: Text of the MJCF that describes the robot.
        folder: Folder of the meshes.
        where: Name of the file in errors.
        elsewhere: Features, by their names in `left_out`, that the caller states elsewhere.

    Raises:
        RobotError: The file describes another arm, or cannot represent the identified numbers.
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
    halfway = compile_mjcf(edits.text().decode(), folder)
    changes += keep_damping(file, halfway, written_servos(file, wanted), edits)
    new = edits.text()
    compiled = compile_mjcf(new.decode(), folder)
    require_same(wanted, described(compiled, wanted, where), where)
    require_servos(compiled, wanted, where)
    require_motors(compiled, motors, where)
    altered = altered_damping(file.compiled, compiled, written_servos(file, wanted))
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
    names, joints = [joint_name(compiled, joint) for joint in range(compiled.njnt)], portable.robot.joints
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
