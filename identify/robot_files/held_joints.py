"""Joints of a URDF that a model holds: fixed where they stand."""

from collections.abc import Collection, Mapping
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from ..errors import RobotError, UnknownJoint
from .toml_fields import number, strings

MOVING = ("revolute", "continuous", "prismatic")
"""Types of joints with one degree of freedom."""


def read_choice(table: Mapping[str, Any], where: str) -> tuple[list[str] | None, dict[str, float]]:
    """Keys `joints`, which move, None for all; and `held`, joints with their positions [rad, m].

    Raises:
        RobotError: They are not as they should be, or name a joint both.
    """
    moving = strings(table["joints"], "joints") if "joints" in table else None
    held = table.get("held", {})
    if not isinstance(held, dict):
        raise RobotError(f"{where}: held is {held!r}; expected held = {{ JOINT = POSITION, ... }} [rad, m]")
    both = sorted(set(moving or ()) & set(held))
    if both:
        raise RobotError(f"{where}: {', '.join(both)} in joints, which move, and in held")
    return moving, {joint: number(value, f"held: {joint}") for joint, value in held.items()}


def hold(
    joints: Mapping[str, Element], moving: Collection[str] | None, held: Mapping[str, float], where: str
) -> None:
    """Fix every joint that is not named as moving, at its position in `held` or at zero.

    Raises:
        UnknownJoint: One that is named is not there.
        RobotError: One with a position has not one degree of freedom.
    """
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


def axis_of(joint: Element) -> np.ndarray:
    """Axis as it is written, shape (3,)."""
    element = joint.find("axis")
    # the default that URDF defines
    return _numbers("1 0 0" if element is None else element.get("xyz", "1 0 0"))


def _numbers(text: str) -> np.ndarray:
    return np.array([float(word) for word in text.split()])


def _place(joint: Element, position: float, where: str) -> None:
    """Move a joint's origin to where its position takes it [rad, m]."""
    axis, kind = axis_of(joint), joint.get("type")
    if kind not in MOVING or not np.any(axis):
        raise RobotError(f"{where} cannot be held at a position: it is {kind}, axis {axis.tolist()}")
    axis = axis / np.linalg.norm(axis)
    origin = joint.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    xyz, rpy = (_numbers(origin.get(key, "0 0 0")) for key in ("xyz", "rpy"))
    rotation = pin.rpy.rpyToMatrix(rpy)
    if kind == "prismatic":
        xyz = xyz + rotation @ axis * position
    else:
        rotation = rotation @ pin.exp3(axis * position)
    for key, values in (("xyz", xyz), ("rpy", pin.rpy.matrixToRpy(rotation))):
        origin.set(key, " ".join(repr(float(value)) for value in values))
