"""Patch: the user's own MJCF with what was found in it, and every other byte as it was.

What MuJoCo makes of the new text is compared with the model before it is handed out.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..errors import RobotError
from ..fit.identified import Standard
from ..robot_files.mjcf import body_parts, compile_mjcf
from ..robot_files.mjcf_drives import servos
from ..robot_files.mjcf_names import joint_name
from .mjcf_changes import Change, File, body_changes, change_gravity, joint_changes
from .mjcf_elements import Elements
from .mjcf_same import described, require_same, taken
from .mjcf_servos import keep_damping, require_servos, servo_changes, written_servos
from .portable import Portable, left_out
from .spread import Spread
from .xml_text import Edits, read_tags

FEATURES = ("bodies", "gravity", "armature", "damping", "dry", "stiffness", "uncertainty")


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
    wanted, below = taken(portable)
    spread, edits = Spread(portable.model, found), Edits(text)
    changes = [
        *joint_changes(file, wanted, spread, edits), *body_changes(file, wanted, spread, edits),
        *servo_changes(file, wanted, edits),
    ]  # fmt: skip
    gravity = change_gravity(file, wanted, edits)
    halfway = compile_mjcf(edits.text().decode(), folder)
    changes += keep_damping(file, halfway, written_servos(file, wanted), edits)
    new = edits.text()
    compiled = compile_mjcf(new.decode(), folder)
    require_same(wanted, described(compiled, wanted, where), where)
    require_servos(compiled, wanted, where)
    left = _left(wanted, spread, bool(servos(compiled, wanted.robot.joints)))
    return Patch(new, tuple(changes), (*below, *gravity, *left))


def _read(portable: Portable, text: bytes, folder: str, where: str) -> File:
    try:
        root, compiled = read_tags(text, where), compile_mjcf(text.decode(), folder)
    except UnicodeDecodeError as error:
        raise RobotError(f"{where}: not UTF-8; write it as UTF-8") from error
    elements = Elements(root, compiled, where)
    every, joints = [joint_name(compiled, joint) for joint in range(compiled.njnt)], portable.robot.joints
    if missing := [joint for joint in joints if joint not in every]:
        raise RobotError(f"{where} has no joint {', '.join(missing)}; it is of another arm")
    nominal = described(compiled, portable, where)
    parts = body_parts(compiled, joints, {}, where)
    return File(where, elements, compiled, [every.index(joint) for joint in joints], parts, nominal)


def _left(portable: Portable, spread: Spread, has_servos: bool) -> list[str]:
    """What the file cannot hold; of constant torques those that are told apart from none."""
    joints = portable.joints
    halves = np.array([spread.half(place, "constant") for place in range(portable.robot.dof)])
    alone = np.where(np.abs(joints.constant) <= halves, 0.0, joints.constant)
    features = (*FEATURES, "servos") if has_servos else FEATURES
    return left_out(replace(portable, joints=replace(joints, constant=alone)), features)
