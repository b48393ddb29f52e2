"""Scores: which concealed items an answer names, and what it names that was not concealed.

An item is named if the answer has its kind on its joints. Equal physics counts as the same kind: a cable is a
spring, a ripple, or their sum, which is a curve over position; and in a log of commands alone the damping of
a servo is that of its joint. Several regroupings of link masses move an arm alike, so a mass may be named on
the body of a neighboring joint.
"""

from collections.abc import Iterable
from typing import Any, NamedTuple

import mujoco

from exidyn.identification.model import Model

from .real_arm import Item


class Said(NamedTuple):
    """What was said about an arm; joints are indices from 0."""

    findings: frozenset[tuple[str, int]]  # Effect and joint of each finding; -1 for the whole arm
    servos: frozenset[tuple[str, int]]  # Quantity and joint of each changed servo
    numbers: frozenset[tuple[str, int]]  # Attribute and joint of each changed number of the file
    changed: frozenset[tuple[str, str]]  # Element and attribute of every change in the file, of servos too
    file: bytes  # Text of the file
    attached: bytes  # Text of the file to which effects are attached
    arm: Model  # Arm of those effects
    attaches: bool = False  # Whether there are such effects
    commands: str = "position"  # What the simulation commands, "position" or "torque"
    held: bool = False  # Whether commands are held from sample to sample


def said(result: Any, original: str) -> Said:
    """What the result of a gap says about an arm whose original file has this text."""
    model, joints = mujoco.MjModel.from_xml_string(original), list(result.diagnosis.joints)
    changes = [*result.file.changes, *result.attached.changes]
    servos = {(servo.quantity, int(servo.joint)) for servo in result.servos}
    written = {(change.where, change.attribute) for change in result.file.changes}
    named = {(f"actuator of {joints[joint]}", quantity) for quantity, joint in servos}
    of_actuators = {pair for pair in written if pair[0].startswith("actuator")}
    return Said(
        frozenset((one.effect, int(joint)) for one in result.findings for joint in one.joints or (-1,)),
        frozenset(servos),
        frozenset(_numbers(model, joints, changes)),
        # A servo is a change of the file whether or not its attributes are listed there.
        frozenset(written if of_actuators else written | named),
        result.file.text,
        result.attached.text,
        result.attached.arm,
        result.attached.attaches,
        result.commands,
        result.held,
    )


def _numbers(model: mujoco.MjModel, joints: list[str], changes: Iterable[Any]) -> Iterable[tuple[str, int]]:
    """Changes of joints and bodies, with the joint that moves the body."""
    for change in changes:
        element, _, name = change.where.partition(" ")
        name = name.strip("'")
        if element == "joint" and name in joints:
            yield change.attribute, joints.index(name)
        elif element == "body" and (joint := _joint_of(model, joints, name)) >= 0:
            yield change.attribute.split()[0], joint


def _joint_of(model: mujoco.MjModel, joints: list[str], body: str) -> int:
    """Index of the joint that moves a body; -1 if no joint of the arm does."""
    ids = [int(model.joint(name).bodyid[0]) for name in joints]
    current = model.body(body).id
    while current and current not in ids:
        current = int(model.body_parentid[current])
    return ids.index(current) if current else -1


FRICTION = {"coulomb_friction", "friction_asymmetry"}
BODIES = {"link_inertia", "payload"}
WHOLE = -1
"""Joint of what concerns the whole arm."""


class Names(NamedTuple):
    """What names an item of a kind: effects of findings, quantities of servos, attributes of the file."""

    effects: frozenset[str] = frozenset()
    servos: frozenset[str] = frozenset()
    numbers: frozenset[str] = frozenset()


def _names(effects: Iterable[str] = (), servos: Iterable[str] = (), numbers: Iterable[str] = ()) -> Names:
    return Names(frozenset(effects), frozenset(servos), frozenset(numbers))


NAMES: dict[str, Names] = {
    "delay": _names({"time_delay"}, {"delay"}),
    "kp": _names({"drive_gain"}, {"kp"}),
    "kv": _names({"viscous_friction"}, {"kv"}, {"damping"}),
    "forcerange": _names({"current_clipping", "drive_gain_saturation"}, {"forcerange"}),
    "coulomb": _names(FRICTION, (), {"frictionloss"}),
    "viscous": _names({"viscous_friction"}, {"kv"}, {"damping"}),
    "armature": _names({"rotor_inertia"}, (), {"armature"}),
    "stribeck": _names({"stribeck_friction"}),
    "load": _names({"load_dependent_friction"}),
    "thermal": _names({"temperature_dependent_friction", "warming_friction"}),
    "cable": _names({"joint_spring", "hose_spring", "torque_ripple", "position_curve"}),
    "spring": _names({"joint_spring", "hose_spring"}, (), {"stiffness", "springref"}),
    "mass": _names(BODIES, (), {"mass", "pos", "fullinertia"}),
    "tilt": _names({"base_tilt"}),
    "gravcomp": _names({"gravity_compensation"}, (), {"gravcomp"}),
}
SAME_IN_COMMANDS = {"kv": "damping", "viscous": "kv"}
"""Kinds whose second name counts only in logs of commands alone, where both are one torque."""


class Score(NamedTuple):
    """Scores of one arm: kinds and joints."""

    concealed: tuple[tuple[str, tuple[int, ...]], ...]  # Concealed items
    named: tuple[tuple[str, tuple[int, ...]], ...]  # Those that are named
    false: tuple[tuple[str, int], ...]  # What is named and was not concealed


def score(items: Iterable[Item], answer: Said, with_torque: bool) -> Score:
    """Score of an answer about an arm with these items."""
    items = tuple(items)
    named = [
        item
        for item in items
        if all(
            any(_has(accepted(item.kind, with_torque), answer, near) for near in _near(item.kind, joint))
            for joint in item.joints or (WHOLE,)
        )
    ]
    false = {(effect, joint) for effect, joint in answer.findings if not _explained(items, effect, joint, 0)}
    false |= {(kind, joint) for kind, joint in answer.servos if not _explained(items, kind, joint, 1)}
    concealed, found = (tuple((item.kind, item.joints) for item in group) for group in (items, named))
    return Score(concealed, found, tuple(sorted(false)))


def accepted(kind: str, with_torque: bool) -> Names:
    """What names an item of a kind, in logs with torque or of commands alone."""
    names = NAMES[kind]
    if not with_torque or kind not in SAME_IN_COMMANDS:
        return names
    if kind == "kv":
        return _names((), names.servos)
    return names._replace(servos=frozenset())


def _near(kind: str, joint: int) -> tuple[int, ...]:
    """Joints on which an item may be named; None of the base's is on a joint in particular."""
    if joint == WHOLE:
        return tuple(range(WHOLE, 64))
    return (joint - 1, joint, joint + 1) if kind == "mass" else (joint,)


def _has(names: Names, answer: Said, joint: int) -> bool:
    """Whether an answer has one of these names on a joint, or a finding on the whole arm."""
    return (
        any((effect, place) in answer.findings for effect in names.effects for place in (joint, WHOLE))
        or any((quantity, joint) in answer.servos for quantity in names.servos)
        or any((attribute, joint) in answer.numbers for attribute in names.numbers)
    )


def _explained(items: Iterable[Item], name: str, joint: int, field: int) -> bool:
    """Whether a finding (field 0) or a servo (field 1) is one of the concealed items."""
    for item in items:
        near = {place for own in item.joints or (WHOLE,) for place in _near(item.kind, own)}
        if name in NAMES[item.kind][field] and (joint == WHOLE or joint in near):
            return True
    return False
