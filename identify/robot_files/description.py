"""A file that describes an arm: a URDF, xacro macros that expand to a URDF, or an MJCF."""

from collections.abc import Collection
from pathlib import Path
from types import MappingProxyType
from xml.etree import ElementTree

from ..arm.robot import Held
from . import urdf
from .kinematics import Kinematics
from .mjcf import compile_mjcf, mjcf_kinematics, movable_mjcf_joints
from .toml_fields import read_text

XML = (".xml", ".mjcf")
"""Endings of MJCF files; a file with such an ending may nevertheless be a URDF."""
ENDINGS = (*urdf.ENDINGS, *XML)
NAMED = ".urdf, .xacro, MJCF (.xml)"
"""The endings, for messages."""


def is_description(path: Path) -> bool:
    """Whether a file's ending is that of a description."""
    return path.suffix.lower() in ENDINGS


def is_mjcf(path: Path) -> bool:
    """Whether a file is an MJCF, by its ending and, if that is ambiguous, its outermost element."""
    if path.suffix.lower() not in XML:
        return False
    try:
        return ElementTree.fromstring(read_text(path)).tag != "robot"
    except ElementTree.ParseError:
        return True  # MuJoCo says what is wrong with it


def read_kinematics(
    path: Path, moving: Collection[str] | None = None, held: Held = MappingProxyType({})
) -> Kinematics:
    """Kinematics of a description.

    Args:
        path: Path of the file.
        moving: Names of the joints that move; the others are held. None: all joints except `held`.
        held: Names of joints that are held away from their reference, and their positions [rad, m].
            A free joint of an MJCF has a position and a quaternion, a ball a quaternion.

    Raises:
        RobotError: The file is wrong, or has content that no model can represent; the message names it.
    """
    if is_mjcf(path):
        return mjcf_kinematics(compile_mjcf(path), str(path), moving, held)
    return urdf.parse_urdf(urdf.read_urdf(path), str(path), moving, held)


def movable_joints(path: Path) -> tuple[list[str], list[str]]:
    """Joints that are not fixed: joints that a model can have, and joints that have to be held."""
    if is_mjcf(path):
        return movable_mjcf_joints(path)
    return urdf.movable_joints(urdf.read_urdf(path), str(path))
