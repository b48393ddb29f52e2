"""Robots in URDF, or in xacro macros that expand to it: kinematics, inertias and limits, by Pinocchio."""

from collections.abc import Collection, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from ..arm.robot import Held, Limits
from ..errors import BrokenTree, RobotError, UnknownJoint
from .kinematics import Kinematics, inertia_elements, named_flange, rigid_inertia
from .toml_fields import number, numbers, read_text, strings
from .urdf_checks import MOVING, axis_of, check_joint, check_urdf, link_at, numbers_of, read_tree, urdf_doubts
from .xacro_macros import expanded

XACRO = ".xacro"
ENDINGS = (".urdf", XACRO)
FRANKA = ("panda_link8", "fer_link8", "fr3_link8", "fp3_link8", "fr3v2_link8")
FLANGES = ("tool0", *FRANKA, "flange")
"""Names (or ends of names) of a controller's own flange, the most likely first; a tool may be fixed to it."""
TOOLS = ("ee_link", "end_effector", "tcp", "link_ee")
"""Names, or ends of names, of links that carry payloads if nothing is fixed to them."""
FAR = 1e300
"""A limit that no joint reaches and that urdfdom, which has no infinity, can read."""


def read_urdf(path: Path) -> str:
    """Text of a URDF; the package xacro expands macros, with the defaults of their arguments."""
    text = read_text(path)
    return expanded(path) if path.suffix.lower() == XACRO else text


def parse_urdf(
    text: str, where: str = "URDF", moving: Collection[str] | None = None, held: Held = MappingProxyType({})
) -> Kinematics:
    """Kinematics of a URDF; a `continuous` joint becomes a revolute joint without limits.

    `moving` and `held` are those of `read_kinematics`; `where` is the name of the file in messages. Raises
    `BrokenTree` if it is not one tree of joints with one degree of freedom.
    """
    root = read_tree(text, where)
    joints = {joint.get("name", ""): joint for joint in root.findall("joint")}
    check_urdf(root, where)
    _hold(joints, moving, held, where)
    for name, joint in joints.items():
        check_joint(joint, f"{where}: joint '{name}'")
    limits = {name: _limits(joint) for name, joint in joints.items()}
    for joint in joints.values():
        _make_plain(joint)
    for link in root.findall("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)  # `read_geometry` reads them; urdfdom would complain about unknown shapes
    model = _load(ElementTree.tostring(root, encoding="unicode"), where)
    lower, upper, velocity, effort = np.array([limits[joint] for joint in list(model.names)[1:]]).T
    unlimited = np.full(model.nv, np.inf)
    described = Limits(lower, upper, velocity, unlimited, unlimited, effort)
    doubts = tuple(urdf_doubts(root, where))
    return Kinematics(model, described, *_flange(model, root), doubts=doubts, held=dict(held))


def pinocchio_kinematics(model: pin.Model) -> Kinematics:
    """Kinematics of a Pinocchio model; limits of zero, and those beyond `FAR`, are infinite."""
    lower, upper = model.lowerPositionLimit, model.upperPositionLimit
    bounded = (lower < upper) & (np.abs([lower, upper]).max(axis=0) < FAR)
    position = np.where(bounded, lower, -np.inf), np.where(bounded, upper, np.inf)
    velocity, effort = (
        np.where((limit > 0.0) & (limit < FAR), limit, np.inf)
        for limit in (model.velocityLimit, model.effortLimit)
    )
    unlimited = np.full(model.nv, np.inf)
    limits = Limits(*position, velocity, unlimited, unlimited, effort)
    return Kinematics(model, limits, *_flange(model, ElementTree.Element("robot")))


def movable_joints(text: str, where: str = "URDF") -> tuple[list[str], list[str]]:
    """Joints of a URDF that are not fixed: joints that a model can have, and joints that have to be held."""
    free: list[str] = []
    bound: list[str] = []
    for joint in read_tree(text, where).findall("joint"):
        if joint.get("type") != "fixed":
            plain = joint.get("type") in MOVING and joint.find("mimic") is None
            (free if plain else bound).append(joint.get("name", ""))
    return free, bound


def read_choice(table: Mapping[str, Any], where: str) -> tuple[list[str] | None, Held]:
    """Values of the keys `joints`, joints that move, or None; and `held`, joints with positions [rad, m]."""
    moving = strings(table["joints"], "joints") if "joints" in table else None
    held = read_held(table.get("held", {}), where)
    conflicting = sorted(set(moving or ()) & set(held))
    if conflicting:
        raise RobotError(f"{where}: {', '.join(conflicting)} in joints, which move, and in held")
    return moving, held


def read_held(held: object, where: str) -> Held:
    """Positions of held joints: a number [rad, m] each, or a list for a free joint or a ball of an MJCF."""
    if not isinstance(held, dict):
        raise RobotError(f"{where}: held is {held!r}; expected held = {{ JOINT = POSITION, ... }} [rad, m]")
    return {
        joint: tuple(numbers(value, len(value), f"held: {joint}").tolist())
        if isinstance(value, list)
        else number(value, f"held: {joint}")
        for joint, value in held.items()
    }


def _hold(joints: Mapping[str, Element], moving: Collection[str] | None, held: Held, where: str) -> None:
    """Fix every joint that does not move, at its position in `held` or at zero."""
    for name in (*(moving or ()), *held):
        if name not in joints:
            raise UnknownJoint(name, where, list(joints))
    for name in joints.keys() - set(joints if moving is None else moving) | held.keys():
        joint = joints[name]
        if name in held:
            _place(joint, held[name], f"{where}: joint '{name}'")
        joint.set("type", "fixed")
        for element in joint.findall("mimic"):
            joint.remove(element)


def _place(joint: Element, position: float | tuple[float, ...], where: str) -> None:
    """Apply a position [rad, m] to a joint's origin."""
    axis, kind = axis_of(joint), joint.get("type")
    if kind not in MOVING or not np.any(axis) or isinstance(position, tuple):
        raise RobotError(f"{where} cannot be held at a position: it is {kind}, axis {axis.tolist()}")
    axis = axis / np.linalg.norm(axis)
    origin = joint.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    xyz, rpy = (numbers_of(origin.get(key, "0 0 0")) for key in ("xyz", "rpy"))
    rotation = pin.rpy.rpyToMatrix(rpy)
    if kind == "prismatic":
        xyz = xyz + rotation @ axis * position
    else:
        rotation = rotation @ pin.exp3(axis * position)
    for key, values in (("xyz", xyz), ("rpy", pin.rpy.matrixToRpy(rotation))):
        origin.set(key, " ".join(repr(float(value)) for value in values))


def _limits(joint: Element) -> tuple[float, float, float, float]:
    """Lower, upper, velocity and effort limit; a missing or zero limit, which would lock a joint, is inf."""
    element = joint.find("limit")
    get = {} if element is None else element.attrib
    lower, upper = float(get.get("lower", 0)), float(get.get("upper", 0))
    if joint.get("type") == "continuous" or lower == upper:
        lower, upper = -np.inf, np.inf
    velocity, effort = float(get.get("velocity", 0)), float(get.get("effort", 0))
    return lower, upper, velocity if velocity > 0 else np.inf, effort if effort > 0 else np.inf


def _make_plain(joint: Element) -> None:
    """Make a joint one that Pinocchio gives one position: revolute or prismatic, unit axis, with limits."""
    if joint.get("type") not in MOVING:
        return
    joint.set("type", "prismatic" if joint.get("type") == "prismatic" else "revolute")
    axis = axis_of(joint)
    length = np.linalg.norm(axis)
    if abs(length - 1.0) > 1e-12:
        for element in joint.findall("axis"):
            joint.remove(element)
        ElementTree.SubElement(joint, "axis", xyz=" ".join(repr(float(x)) for x in axis / length))
    for element in joint.findall("limit"):
        joint.remove(element)
    far = repr(FAR)
    ElementTree.SubElement(joint, "limit", lower=f"-{far}", upper=far, velocity=far, effort=far)


def _load(text: str, where: str) -> pin.Model:
    try:
        model = pin.buildModelFromXML(text)
    except (RuntimeError, ValueError) as error:
        first = (str(error).strip() or "no reason given").splitlines()[0]
        raise BrokenTree(f"{where}: {first}") from error
    if model.nv == 0:
        raise BrokenTree(f"{where}: no joint moves; at least one must be {', '.join(MOVING)}")
    for name, body in zip(list(model.names)[1:], list(model.inertias)[1:], strict=True):
        elements = inertia_elements(body.inertia)
        rigid_inertia(body.mass, body.lever, elements, f"{where}: body moved by joint '{name}'")
    return model


def _flange(model: pin.Model, root: Element) -> tuple[pin.SE3, str]:
    """Placement, in the last joint's frame, of the link whose name is that of a flange, and its name."""
    parents = {link_at(joint, "parent") for joint in root.findall("joint")}
    candidates = {
        frame.name: frame.placement
        for frame in model.frames
        if frame.type == pin.FrameType.BODY
        and frame.parentJoint == model.njoints - 1
        and (frame.name.lower().endswith(FLANGES) or frame.name not in parents)
    }
    return named_flange(model, candidates, (*FLANGES, *TOOLS))
