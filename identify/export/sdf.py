"""SDFormat for Gazebo and Drake: links, joints, limits, and friction and springs in `<dynamics>`."""

from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from exidyn.quoting import xml_document

from ..arm.newton_euler import Joint, joints_of, link_frames
from ..robot_files.robot_text import words
from .portable import Portable

FEATURES = ("bodies", "damping", "dry", "stiffness")
VERSION = "1.9"
"""Version of the format; later readers convert it."""
WORLD = "world"
"""Parent of the first joint; SDFormat prescribes the name."""


def sdf(portable: Portable) -> str:
    """Links without shape, fixed to the world; springs and friction of the joints."""
    robot = portable.robot
    root = Element("sdf", version=VERSION)
    model = SubElement(root, "model", name=robot.name)
    joints, frames = joints_of(robot.kinematics), link_frames(robot.kinematics)
    links = [frame.child for frame in frames]
    for place, joint in enumerate(joints):
        link = SubElement(model, "link", name=links[place])
        _add_pose(link, joint.placement, links[joint.parent] if joint.parent >= 0 else "__model__")
        _add_inertial(link, robot.kinematics.inertias[place + 1])
    for place, joint in enumerate(joints):
        parent = links[joint.parent] if joint.parent >= 0 else WORLD
        _add_joint(model, portable, place, joint, parent, links[place])
    flange = SubElement(model, "frame", {"name": "flange", "attached_to": links[-1]})
    _add_pose(flange, robot.flange)
    return xml_document(root)


def _add_pose(element: Element, placement: pin.SE3, relative_to: str = "") -> None:
    angles = pin.rpy.matrixToRpy(placement.rotation)
    pose = SubElement(element, "pose", {"relative_to": relative_to} if relative_to else {})
    pose.text = words((*placement.translation, *angles))


def _add_inertial(link: Element, body: pin.Inertia) -> None:
    inertial = SubElement(link, "inertial")
    _add_pose(inertial, pin.SE3(np.eye(3), body.lever))
    SubElement(inertial, "mass").text = repr(float(body.mass))
    inertia = SubElement(inertial, "inertia")
    for name, (i, j) in {
        "ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2),
    }.items():  # fmt: skip
        SubElement(inertia, name).text = repr(float(body.inertia[i, j]))


def _add_joint(model: Element, portable: Portable, place: int, joint: Joint, parent: str, child: str) -> None:
    kind = "revolute" if joint.revolute else "prismatic"
    element = SubElement(model, "joint", name=portable.robot.joints[place], type=kind)
    SubElement(element, "parent").text = parent
    SubElement(element, "child").text = child
    axis = SubElement(element, "axis")
    SubElement(axis, "xyz").text = words(joint.axis)
    for tag, numbers in (("limit", _limits(portable, place)), ("dynamics", _dynamics(portable, place))):
        group = SubElement(axis, tag)
        for name, value in numbers.items():
            SubElement(group, name).text = repr(float(value))


def _limits(portable: Portable, place: int) -> dict[str, float]:
    """Finite limits of a joint; a missing entry means no limit."""
    limits = portable.robot.limits
    all_limits = {
        "lower": limits.position_lower, "upper": limits.position_upper, "effort": limits.torque,
        "velocity": limits.velocity,
    }  # fmt: skip
    return {name: values[place] for name, values in all_limits.items() if np.isfinite(values[place])}


def _dynamics(portable: Portable, place: int) -> dict[str, float]:
    joints = portable.joints
    stiffness = joints.stiffness[place]
    return {
        "damping": max(joints.damping[place], 0.0),
        "friction": max(joints.dry[place], 0.0),
        "spring_reference": -joints.constant[place] / stiffness if stiffness else 0.0,
        "spring_stiffness": stiffness,
    }
