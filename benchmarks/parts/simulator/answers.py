"""What a gap says about an arm, read from its result: the only place that knows the form of the result."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import mujoco

from exidyn.identification.model import Model


class Said(NamedTuple):
    """What was said about an arm; joints are indices from 0."""

    # Effect and joint of each finding; joint -1 for a finding about the whole arm
    findings: frozenset[tuple[str, int]]
    servos: frozenset[tuple[str, int]]  # Quantity and joint of each changed servo
    # Attribute and joint of each changed number of the file, of a joint or of its body
    numbers: frozenset[tuple[str, int]]
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
        frozenset(_findings(result.findings)),
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


def _findings(findings: Iterable[Any]) -> Iterable[tuple[str, int]]:
    for finding in findings:
        yield from ((finding.effect, int(joint)) for joint in finding.joints or (-1,))


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
