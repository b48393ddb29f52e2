"""Elastic gears and gears with play in MJCF: a second joint on a joint's axis is the twist of the gear.

The original joint, with its name, armature, friction and actuator, is the motor, where the encoder is. The
twist has no inertia. Its stiffness and damping represent an elastic gear. Its range represents play, and the
ends of the range the teeth: the link strikes them like a spring and rests on them like a rigid stop. MuJoCo's
constraints derive an acceleration from `solreflimit`, so their stiffness is proportional to the link's
inertia.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from exidyn.quoting import xml_attribute

from ..errors import RobotError
from ..robot_files.mjcf import compile_mjcf
from ..robot_files.mjcf_elements import joint_names, turns
from .changes import DIGITS, Change
from .xml_text import Edits, Elements, Tag, read_tags

TWIST = "{}_twist"
"""Name of the second joint."""
PLAIN = (
    'frictionloss="0" armature="0" ref="0" springref="0" springdamper="0 0" margin="0" '
    'actuatorfrclimited="false"'
)
"""Attributes that override defaults of a class, which must not apply to a twist."""
STOP = "0.95 0.99 0.001"
"""MuJoCo's impedance of the teeth, near 1 so that the load has little effect on the impact."""


class Gear(NamedTuple):
    """An elastic gear, or a gear with play."""

    joint: str  # name of the joint
    stiffness: float  # stiffness of the gear, or of the teeth of a gear with play [N m/rad; prismatic: N/m]
    damping: float  # damping [N m s/rad]
    play: float = 0.0  # full width of the play [rad]; 0 for none
    # Half of the 95 % interval of the stiffness [N m/rad]; infinite if unknown.
    stiffness_half: float = np.inf
    play_half: float = np.inf  # half of the 95 % interval of the play [rad]; infinite if unknown


def add_gears(text: bytes, folder: str, where: str, gears: Sequence[Gear]) -> tuple[bytes, list[Change]]:
    """Add a twist for each gear; returns the new text and the changes."""
    changes: list[Change] = []
    for gear in gears:  # sequentially, since addresses and keyframes change
        root, compiled = read_tags(text, where), compile_mjcf(text.decode(), folder)
        edits, elements = Edits(text), Elements(root, compiled, where)
        joint = _joint(compiled, gear.joint, where)
        body = elements.tag("body", int(compiled.jnt_bodyid[joint]))
        edits.add_inside(body, _element(compiled, joint, gear, elements.degrees))
        first = int(compiled.body_jntadr[compiled.jnt_bodyid[joint]])
        _lengthen(root, edits, "qpos", int(compiled.jnt_qposadr[first]))
        _lengthen(root, edits, "qvel", int(compiled.jnt_dofadr[first]))
        text = edits.text()
        compile_mjcf(text.decode(), folder)
        changes += _changes(gear, turns(compiled, joint))
    return text, changes


def _joint(compiled: Any, name: str, where: str) -> int:
    """Index of a joint, after a check that it can have a twist."""
    names = joint_names(compiled)
    if name not in names:
        raise RobotError(f"{where}: no joint has the name '{name}'; give the joint a name")
    joint = names.index(name)
    if TWIST.format(name) in names:
        raise RobotError(f"{where}: joint '{name}' already has a twist, '{TWIST.format(name)}'")
    if not compiled.dof_armature[compiled.jnt_dofadr[joint]] > 0.0:
        raise RobotError(
            f"{where}: joint '{name}' has no armature, and a motor without inertia cannot move relative to "
            "its link. Give the joint an armature"
        )
    return joint


def _element(compiled: Any, joint: int, gear: Gear, degrees: bool) -> str:
    """Element of the twist joint; axis and position of the compiled joint are in the body frame."""
    vectors = compiled.jnt_axis[joint], compiled.jnt_pos[joint]
    axis, anchor = (" ".join(f"{value:.{DIGITS}g}" for value in vector) for vector in vectors)
    name = xml_attribute(TWIST.format(gear.joint))
    hinge = turns(compiled, joint)
    kind = f'<joint name={name} type="{"hinge" if hinge else "slide"}" axis="{axis}" pos="{anchor}" {PLAIN}'
    if not gear.play:
        spring = f'stiffness="{gear.stiffness:.{DIGITS}g}" damping="{gear.damping:.{DIGITS}g}"'
        return f'{kind} limited="false" {spring}/>'
    dof = int(compiled.jnt_dofadr[joint])
    link = float(compiled.dof_M0[dof] - compiled.dof_armature[dof])
    angular = np.sqrt(gear.stiffness / link)
    ratio = gear.damping / (2.0 * link * angular)
    half = 0.5 * gear.play * (np.degrees(1.0) if degrees and hinge else 1.0)
    stop = f'solreflimit="{1.0 / (ratio * angular):.{DIGITS}g} {ratio:.{DIGITS}g}" solimplimit="{STOP}"'
    limits = f'limited="true" range="{-half:.{DIGITS}g} {half:.{DIGITS}g}"'
    return f'{kind} {limits} stiffness="0" damping="0" {stop}/>'


def _lengthen(root: Tag, edits: Edits, attribute: str, place: int) -> None:
    """Insert a zero into the positions or velocities of all keyframes."""
    for frames in (child for child in root.children if child.name == "keyframe"):
        for key in frames.children:
            numbers = key.attributes.get(attribute, "").split()
            if numbers:
                edits.set(key, **{attribute: " ".join([*numbers[:place], "0", *numbers[place:]])})


def _changes(gear: Gear, hinge: bool) -> list[Change]:
    """Changes compared with a rigid gear, which has no play and infinite stiffness."""
    where = f"joint '{TWIST.format(gear.joint)}', new"
    units = ("rad", "N m/rad", "N m s/rad") if hinge else ("m", "N/m", "N s/m")
    if gear.play:
        return [Change(where, "range", units[0], 0.0, gear.play, gear.play_half)]
    return [
        Change(where, "stiffness", units[1], np.inf, gear.stiffness, gear.stiffness_half),
        Change(where, "damping", units[2], 0.0, gear.damping, np.inf),
    ]
