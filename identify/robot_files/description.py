"""A file that describes an arm: a URDF, xacro macros that make one, or an MJCF."""

from collections.abc import Collection, Mapping
from pathlib import Path
from types import MappingProxyType
from xml.etree import ElementTree

from . import urdf
from .kinematics import Kinematics
from .mjcf import movable_mjcf_joints, read_mjcf
from .toml_fields import read_text

XML = (".xml", ".mjcf")
"""Endings of MJCF; a file of that name may be a URDF all the same."""
ENDINGS = (*urdf.ENDINGS, *XML)
NAMED = ".urdf, .xacro, MJCF (.xml)"
"""They, in words."""


def is_description(path: Path) -> bool:
    """Whether a file's name is that of a description."""
    return path.suffix.lower() in ENDINGS


def is_mjcf(path: Path) -> bool:
    """Whether a file is an MJCF: by its ending, and its outermost element where that leaves it open.

    Raises:
        RobotError: The file cannot be read.
    """
    if path.suffix.lower() not in XML:
        return False
    try:
        return ElementTree.fromstring(read_text(path)).tag != "robot"
    except ElementTree.ParseError:
        return True  # MuJoCo says what is wrong with it


def read_kinematics(
    path: Path, moving: Collection[str] | None = None, held: Mapping[str, float] = MappingProxyType({})
) -> Kinematics:
    """Kinematics of a description.

    Args:
        path: The file.
        moving: Joints that move; the others are held. None: all but `held`.
        held: Joints that are held elsewhere than at their reference, and where [rad, m].

    Raises:
        RobotError: The file is wrong, or cannot be taken; the message names what.
    """
    if is_mjcf(path):
        return read_mjcf(path, moving, held)
    return urdf.parse_urdf(urdf.read_urdf(path), str(path), moving, held)


def movable_joints(path: Path) -> tuple[list[str], list[str]]:
    """Joints that are not fixed: those that a model can have, and those that have to be held.

    Raises:
        RobotError: The file is wrong.
    """
    if is_mjcf(path):
        return movable_mjcf_joints(path)
    return urdf.movable_joints(urdf.read_urdf(path), str(path))
