"""Text formats: JSON and robot.toml represent the complete model, URDF the bodies and friction.

PyBullet takes a URDF's link without `<inertial>` as 1 kg, so frames without mass state a mass of 0. Gazebo
drops what moves on a link without mass, so the base, whose mass no torque depends on, has some and stands on
`world`.
"""

from dataclasses import fields
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from exidyn.quoting import json_text, one_line, xml_document

from ..arm.newton_euler import joints_of, link_frames
from ..effects import Effect, name_of
from ..measurements import measurement_name
from ..model import Model
from ..robot_files.effect_rows import key_of
from ..robot_files.robot_text import WORLD, model_text, placement_keys, urdf_text
from .portable import Portable

FORMAT = 1
"""Format version, increased when a reader of the previous version would misinterpret a file."""

NOT_IN_TOML = ("law", "delay", "feed_forward", "integral")
"""Features of servos that a robot file does not have."""


def json(portable: Portable) -> str:
    """A table of links, joints and effects in SI units; infinite or unknown values are null."""
    model, robot = portable.model, portable.robot
    table = {
        "exidyn_model": FORMAT,
        "robot": robot.name,
        "gravity": robot.gravity,
        "joints": [_joint(model, place) for place in range(robot.dof)],
        "coupling": robot.coupling,
        "flange": placement_keys(robot.flange),
        "effects": [_effect(model, effect) for effect in model.effects],
        "measurements": [
            {"name": measurement_name(measurement)}
            | {f.name: getattr(measurement, f.name) for f in fields(measurement)}
            for measurement in model.measurements
        ],
        "servos": None if portable.servos is None else vars(portable.servos),
    }
    return json_text(_plain(table)) + "\n"


def _joint(model: Model, place: int) -> dict[str, Any]:
    """Entry of a joint, its motor, and the link that it moves, in the link's frame."""
    robot = model.robot
    joint, body = joints_of(robot.kinematics)[place], robot.kinematics.inertias[place + 1]
    return {
        "name": robot.joints[place],
        "kind": "revolute" if joint.revolute else "prismatic",
        "parent": robot.joints[joint.parent] if joint.parent >= 0 else None,
        **placement_keys(joint.placement),
        "axis": joint.axis,
        "limits": {name: values[place] for name, values in vars(robot.limits).items()},
        "drive_gain": robot.drive_gain[place],
        "gear_ratio": robot.gear_ratio[place],
        "link": {
            "name": link_frames(robot.kinematics)[place].child,
            "mass": body.mass,
            "center_of_mass": body.lever,
            "inertia_about_center_of_mass": body.inertia,
        },
    }


def _effect(model: Model, effect: Effect) -> dict[str, Any]:
    """Entry of an effect with its fields and parameters; the links have the parameters of bodies."""
    row: dict[str, Any] = {"name": name_of(effect)}
    row |= {key_of(f): getattr(effect, f.name) for f in fields(effect)}
    if effect.of_links:
        return row
    priors = dict(zip(model.names, model.priors, strict=True))
    row["parameters"] = [
        {"name": p.name, "unit": p.unit, "value": priors[p.name].value, "std": priors[p.name].std}
        for p in effect.parameters(model.robot)
    ]
    return row


def _plain(value: Any) -> Any:
    """The value in terms of lists, tables, text and finite numbers."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, str | None):
        return value
    number = float(value)
    return None if not np.isfinite(number) else int(number) if isinstance(value, int) else number


def toml(portable: Portable) -> str:
    """A robot file with the identified model, which every command accepts."""
    return model_text(portable.model)


IN_URDF = ("bodies", "damping", "dry")
BASE_MASS = 1.0
"""Mass [kg] and moments of inertia [kg m^2] of the base, which stands still."""
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def urdf(portable: Portable) -> str:
    """Links as cylinders, fixed to the world; viscous and dry friction in `<dynamics>`."""
    root = ElementTree.fromstring(urdf_text(portable.model))
    places = {one_line(name): place for place, name in enumerate(portable.robot.joints)}
    for joint in root.findall("joint"):
        if (place := places.get(joint.get("name", ""))) is not None:
            damping, friction = portable.joints.damping[place], portable.joints.dry[place]
            SubElement(joint, "dynamics", damping=repr(float(damping)), friction=repr(float(friction)))
    _state_masses(root)
    return xml_document(root)


def _state_masses(root: Element) -> None:
    """Put the base on the world, and give every other link an `<inertial>`."""
    children = {_end(joint, "child") for joint in root.findall("joint")}
    [first] = [str(link.get("name")) for link in root.findall("link") if link.get("name") not in children]
    if first != WORLD:
        root.insert(0, Element("link", name=WORLD))
        joint = SubElement(root, "joint", name=f"{first}_fixed", type="fixed")
        SubElement(joint, "parent", link=WORLD)
        SubElement(joint, "child", link=first)
    bases = {_end(joint, "child") for joint in root.findall("joint") if _end(joint, "parent") == WORLD}
    for link in root.findall("link"):
        if link.find("inertial") is None and link.get("name") != WORLD:
            mass, inertial = BASE_MASS if link.get("name") in bases else 0.0, Element("inertial")
            SubElement(inertial, "mass", value=repr(mass))
            moments = {name: repr(mass if name[1] == name[2] else 0.0) for name in MOMENTS}
            SubElement(inertial, "inertia", moments)
            link.insert(0, inertial)


def _end(joint: Element, tag: str) -> str | None:
    """Name of a joint's parent or child link."""
    end = joint.find(tag)
    return None if end is None else end.get("link")
