"""Write a model as a URDF without meshes: cylinders that a viewer shows as an arm."""

from collections.abc import Iterable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from ..arm.link_frames import LinkFrame, link_frames
from ..arm.newton_euler import Joint, joints_of
from ..arm.robot import Robot
from ..model import Model

SLENDERNESS = 0.06
"""Radius of a drawn link over the reach of the arm."""
WORLD = "world"
TOO_SHORT = 1e-3
"""Axes closer than this [m] are drawn without a link between them."""


def urdf_text(model: Model) -> str:
    """URDF of kinematics, inertias and limits; gravity, drives and friction have no place there.

    Links are called as in `link_frames`, so that a viewer can move this arm by the recorded transforms.
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
    # the schema wants nothing in order, but people read links before joints
    root[:] = sorted(root, key=lambda element: element.tag, reverse=True)
    ElementTree.indent(root)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _add_fixed(root: Element, drawn: dict[str, Element], parent: str, child: str, placement: pin.SE3) -> None:
    """Fix a link to another, which is made if it is the world."""
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
    about = inertia.inertia
    names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    SubElement(inertial, "inertia", {name: repr(float(about[at])) for name, at in names.items()})


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
    # a URDF joint must state effort and velocity; zero is what files write for "unknown"
    SubElement(element, "limit", {k: repr(float(v)) if np.isfinite(v) else "0" for k, v in known.items()})


def _add_origin(element: Element, placement: pin.SE3) -> None:
    rpy = pin.rpy.matrixToRpy(placement.rotation)
    SubElement(element, "origin", xyz=words(placement.translation), rpy=words(rpy))


def words(vector: Iterable[float]) -> str:
    """Numbers as an attribute holds them, to the last digit."""
    return " ".join(repr(float(x)) for x in vector)
