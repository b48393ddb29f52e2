"""Write a model as one robot.toml that needs no other file, and as a URDF for viewers.

Reading the robot.toml gives the same model to the last digit. The URDF shows the arm as cylinders.
"""

from collections.abc import Iterable
from dataclasses import fields
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from exidyn.quoting import xml_document

from ..arm.newton_euler import Joint, LinkFrame, joints_of, link_frames
from ..arm.robot import FLANGE, PositionServo, Robot
from ..effects import Effect, name_of
from ..measurements import Measurement, measurement_name
from ..model import Model
from .effect_rows import key_of
from .kinematics import INERTIA_PLACES, inertia_elements
from .toml_fields import block, lines

FORMAT = 1
RIGID_BODY = "link_inertia"
"""Effect that every arm has, so that files need not name it."""
SLENDERNESS = 0.06
"""Radius of a drawn link, as a share of the longest link."""
WORLD = "world"
TOO_SHORT = 1e-3
"""Axes closer than this [m] are drawn without a link between them."""


def model_text(model: Model) -> str:
    """A robot.toml with the kinematics, limits, drives, effects, measurements and priors of a model."""
    robot = model.robot
    head: dict[str, Any] = {"format": FORMAT, "name": robot.name, "gravity": robot.gravity}
    if robot.held:
        head["held"] = robot.held
    if robot.inertias_stated:
        head["inertial_tolerance"] = robot.inertial_tolerance
    if not any(effect.of_links for effect in model.effects):
        head["rigid_body"] = False
    blocks = [lines(head), _limits(robot)]
    blocks += [block("[drive]", _drive(robot)), block("[flange]", _flange(robot))]
    blocks += [block("[[link]]", link | _inertia(robot, i)) for i, link in enumerate(_links(robot))]
    written: set[str] = set()
    for place, effect in enumerate(model.effects):
        row = _effect_row(effect, model, written)
        if place or row != {"name": RIGID_BODY}:
            blocks.append(block("[[effect]]", row))
    blocks += [
        block("[[measurement]]", {"name": measurement_name(part), **_fields(part)})
        for part in model.measurements
    ]
    single = {n: list(b) for n, b in model.stated.items() if n in model.names and n not in written}
    if single:
        blocks.append(block("[prior]", single))
    return "\n\n".join(blocks) + "\n"


def moving_text(robot: Robot) -> str:
    """A robot.toml with only geometry and limits, without masses."""
    blocks = [_limits(robot), block("[flange]", _flange(robot))]
    return "\n\n".join([*blocks, *(block("[[link]]", link) for link in _links(robot))]) + "\n"


def _limits(robot: Robot) -> str:
    return block("[limits]", {f.name: getattr(robot.limits, f.name) for f in fields(robot.limits)})


def _drive(robot: Robot) -> dict[str, Any]:
    tolerance = robot.drive_gain_tolerance
    return {
        "gain": robot.drive_gain,
        "gain_tolerance": tolerance[0] if np.all(tolerance == tolerance[0]) else tolerance,
        **({"gain_in_inertias": True} if robot.inertias_by_gain else {}),
        "gear_ratio": robot.gear_ratio,
        **({"direct_drive": robot.direct_drive} if robot.direct_drive else {}),
        **({"passive": robot.passive} if robot.passive else {}),
        **({} if robot.servo is None else servo_keys(robot.servo)),
        "coupling": robot.coupling,
    }


def servo_keys(servo: PositionServo) -> dict[str, Any]:
    """Keys of `[drive]` for position servos."""
    limited = bool(np.any(np.isfinite(servo.limit)))
    return {"servo_gain": servo.gain, **({"servo_limit": servo.limit} if limited else {})}


def placement_keys(placement: pin.SE3) -> dict[str, Any]:
    """Keys of a placement in robot files."""
    return {"origin": placement.translation, "rotation": placement.rotation}


def _flange(robot: Robot) -> dict[str, Any]:
    named = {} if robot.flange_name == FLANGE else {"frame": robot.flange_name}
    return named | placement_keys(robot.flange)


def _links(robot: Robot) -> list[dict[str, Any]]:
    """One row per joint, with its placement on its parent."""
    rows = zip(robot.joints, joints_of(robot.kinematics), link_frames(robot.kinematics), strict=True)
    return [
        {
            "joint": name,
            "link": frame.child,
            "parent": robot.joints[joint.parent] if joint.parent >= 0 else "",
            "kind": "revolute" if joint.revolute else "prismatic",
            "axis": joint.axis,
            **placement_keys(joint.placement),
        }
        for name, joint, frame in rows
    ]


def _inertia(robot: Robot, place: int) -> dict[str, Any]:
    inertia = robot.kinematics.inertias[place + 1]
    return {
        "mass": inertia.mass,
        "center_of_mass": inertia.lever,
        "inertia": inertia_elements(inertia.inertia),
    }


def _effect_row(effect: Effect, model: Model, written: set[str]) -> dict[str, Any]:
    """Fields of an effect, and its priors if all its parameters have one; adds those to `written`."""
    row: dict[str, Any] = {"name": name_of(effect), **_fields(effect)}
    names = [parameter.name for parameter in effect.parameters(model.robot)]
    if names and all(name in model.stated for name in names):
        row["values"] = [model.stated[name].value for name in names]
        row["std"] = [model.stated[name].std for name in names]
        written.update(names)
    return row


def _fields(part: Effect | Measurement) -> dict[str, Any]:
    return {key_of(f): value for f in fields(part) if (value := getattr(part, f.name)) is not None}


def urdf_text(model: Model) -> str:
    """URDF with kinematics, inertias and limits; URDF cannot represent gravity, drives and friction.

    Links have the names of `link_frames`, so that a viewer can move this arm by the recorded transforms.
    """
    robot = model.robot
    joints, frames = joints_of(robot.kinematics), link_frames(robot.kinematics)
    lengths = [float(np.linalg.norm(joint.placement.translation)) for joint in joints]
    radius = SLENDERNESS * max(*lengths, 10 * TOO_SHORT)
    root = Element("robot", name=robot.name)
    drawn: dict[str, Element] = {}
    for place, (joint, frame) in enumerate(zip(joints, frames, strict=True)):
        carrier = frames[joint.parent].child if joint.parent >= 0 else WORLD
        start = joint.placement * frame.placement.inverse()
        if frame.parent not in drawn:
            drawn[frame.parent] = SubElement(root, "link", name=frame.parent)
            if joint.parent >= 0 or not start.isIdentity(1e-12):
                _add_fixed(root, drawn, carrier, frame.parent, start)
        _add_cylinder(drawn[frame.parent], np.zeros(3), frame.placement.translation, 0.7 * radius)
        link = drawn[frame.child] = SubElement(root, "link", name=frame.child)
        _add_inertial(link, robot.kinematics.inertias[place + 1])
        _add_cylinder(link, -1.5 * radius * joint.axis, 1.5 * radius * joint.axis, radius)
        _add_joint(root, robot, place, joint, frame)
    _add_cylinder(link, np.zeros(3), robot.flange.translation, 0.7 * radius)
    flange = "flange" if "flange" not in drawn else "tool_flange"
    drawn[flange] = SubElement(root, "link", name=flange)
    _add_fixed(root, drawn, frames[-1].child, flange, robot.flange)
    # the order is irrelevant to parsers, but people expect links before joints
    root[:] = sorted(root, key=lambda element: element.tag, reverse=True)
    return xml_document(root)


def _add_fixed(root: Element, drawn: dict[str, Element], parent: str, child: str, placement: pin.SE3) -> None:
    """Fix a link to another link, which is created if it does not exist."""
    if parent not in drawn:
        drawn[parent] = SubElement(root, "link", name=parent)
    fixed = SubElement(root, "joint", name=f"{child}_fixed", type="fixed")
    SubElement(fixed, "parent", link=parent)
    SubElement(fixed, "child", link=child)
    _add_origin(fixed, placement)


def _add_inertial(link: Element, inertia: pin.Inertia) -> None:
    if inertia.mass == 0:
        return
    inertial = SubElement(link, "inertial")
    _add_origin(inertial, pin.SE3(np.eye(3), inertia.lever))
    SubElement(inertial, "mass", value=repr(float(inertia.mass)))
    elements = zip(INERTIA_PLACES, inertia_elements(inertia.inertia).tolist(), strict=True)
    SubElement(inertial, "inertia", {f"i{axes}": repr(value) for axes, value in elements})


def _add_cylinder(link: Element, start: np.ndarray, end: np.ndarray, radius: float) -> None:
    length = float(np.linalg.norm(end - start))
    if length < TOO_SHORT:
        return
    visual = SubElement(link, "visual")
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), (end - start) / length)
    _add_origin(visual, pin.SE3(turn.toRotationMatrix(), (start + end) / 2))
    geometry = SubElement(visual, "geometry")
    SubElement(geometry, "cylinder", radius=f"{radius:.4g}", length=f"{length:.4g}")


def _add_joint(root: Element, robot: Robot, place: int, joint: Joint, frame: LinkFrame) -> None:
    limits = robot.limits
    bounded = bool(np.all(np.isfinite([limits.position_lower[place], limits.position_upper[place]])))
    kind = "prismatic" if not joint.revolute else "revolute" if bounded else "continuous"
    element = SubElement(root, "joint", name=robot.joints[place], type=kind)
    SubElement(element, "parent", link=frame.parent)
    SubElement(element, "child", link=frame.child)
    _add_origin(element, frame.placement)
    SubElement(element, "axis", xyz=words(joint.axis))
    known = {"effort": limits.torque[place], "velocity": limits.velocity[place]}
    if bounded:
        known |= {"lower": limits.position_lower[place], "upper": limits.position_upper[place]}
    # a URDF joint must state effort and velocity; files use zero for "unknown"
    SubElement(element, "limit", {k: repr(float(v)) if np.isfinite(v) else "0" for k, v in known.items()})


def _add_origin(element: Element, placement: pin.SE3) -> None:
    rpy = pin.rpy.matrixToRpy(placement.rotation)
    SubElement(element, "origin", xyz=words(placement.translation), rpy=words(rpy))


def words(vector: Iterable[float]) -> str:
    """Numbers as the text of an attribute, with all digits."""
    return " ".join(repr(float(x)) for x in vector)
