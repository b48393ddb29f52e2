"""Kinematics, the common form of all descriptions of an arm's geometry, and the `[[link]]` rows for them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from ..arm.newton_euler import link_frames
from ..arm.robot import FLANGE, Held, Limits
from ..errors import BrokenTree, RobotError, UnknownJoint
from .robot_keys import KEYS
from .toml_fields import check_keys, matrix, number, numbers, string

KINDS = ("revolute", "prismatic")
INERTIA_PLACES = {"xx": (0, 0), "xy": (0, 1), "xz": (0, 2), "yy": (1, 1), "yz": (1, 2), "zz": (2, 2)}
"""Element of an inertia -> its row and column."""
FARTHEST_CENTER = 10.0
"""Maximum distance of a body's center of mass from its frame [m]: the largest arms reach 5 m."""
FLAT = 0.02
"""Share by which the largest principal moment may exceed the sum of the others [-]. For a flat plate they are
equal, and rounding to two digits causes such an excess."""


@dataclass(frozen=True)
class Part:
    """Place of a body, or of a row of a table, in the tree of joints."""

    joint: int  # index in Pinocchio's model of the joint that moves it, 0 for the base
    placement: pin.SE3  # placement of its frame in the frame of that joint


@dataclass(frozen=True)
class Kinematics:
    """Tree of joints, and the other content of its description."""

    model: pin.Model  # pinocchio model with one degree of freedom per joint and the nominal inertias
    limits: Limits | None = None  # joint limits; None if the description has none
    # Placement of the flange in the last link's frame.
    flange: pin.SE3 = field(default_factory=pin.SE3.Identity)
    flange_name: str = FLANGE  # name of the flange's frame
    # Rotor inertia on the joint side, joint name -> [kg m^2].
    rotor_inertia: Mapping[str, float] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()  # implausible content of the description, one sentence each
    # `[[effect]]` rows that it implies if a robot file has none; None: the usual effects.
    effects: tuple[Mapping[str, Any], ...] | None = None
    # Coupling of motors and joints, as in `Robot`; empty if there is none.
    coupling: np.ndarray = field(default_factory=lambda: np.empty(0))
    # Joints that are held away from their reference, and their positions, as in `Robot`.
    held: Held = field(default_factory=dict)
    # Motor turns per joint turn, shape (n,) [-]; empty if unknown.
    gear_ratio: np.ndarray = field(default_factory=lambda: np.empty(0))


def rigid_inertia(mass: float, center_of_mass: np.ndarray, inertia: np.ndarray, where: str) -> pin.Inertia:
    """Inertia from mass [kg], center of mass (3,) [m] and xx xy xz yy yz zz about it (6,) [kg m^2]."""
    check_center(mass, center_of_mass, where)
    if mass < 0 or not np.all(np.isfinite([mass, *center_of_mass, *inertia])):
        raise BrokenTree(f"{where}: mass {mass:g} kg; a mass is a number of at least 0")
    about_center = inertia_matrix(inertia)
    lowest = np.linalg.eigvalsh(about_center)[0]
    # a thin rod has a principal moment of zero, which rounding may make negative
    if lowest < -1e-9 * (1.0 + np.abs(about_center).max()):
        raise BrokenTree(
            f"{where}: principal moment of inertia {lowest:g} kg m² about the center of mass; "
            "none may be negative"
        )
    try:
        return pin.Inertia(mass, center_of_mass, about_center)
    except (RuntimeError, ValueError) as error:
        raise BrokenTree(f"{where}: {error}") from error


def inertia_matrix(elements: Sequence[float] | np.ndarray) -> np.ndarray:
    """Inertia, shape (3, 3), from xx, xy, xz, yy, yz, zz."""
    xx, xy, xz, yy, yz, zz = elements
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def inertia_elements(inertia: np.ndarray) -> np.ndarray:
    """Elements xx, xy, xz, yy, yz, zz of an inertia (3, 3), shape (6,)."""
    return np.array([inertia[at] for at in INERTIA_PLACES.values()])


def check_center(mass: float, center_of_mass: np.ndarray, where: str) -> None:
    """Refuse a body whose center of mass (3,) [m] is farther away than an arm is long."""
    distance = float(np.linalg.norm(center_of_mass))
    if mass > 0.0 and distance > FARTHEST_CENTER:
        raise RobotError(
            f"{where}: center of mass {distance:g} m from its frame; in an arm it is at most "
            f"{FARTHEST_CENTER:g} m away. Is it in millimeters?"
        )


def inertia_doubt(inertia: np.ndarray, where: str) -> str:
    """Why an inertia (3, 3) about a center of mass [kg m^2] is impossible; empty if it is possible."""
    low, middle, high = np.linalg.eigvalsh(inertia)
    if high - low - middle <= FLAT * abs(high) and low >= -FLAT * abs(high):
        return ""
    moments = f"principal moments of inertia {low:.3g}, {middle:.3g}, {high:.3g} kg m²"
    why = "none can be negative" if low < 0.0 else "the largest can be at most the sum of the others"
    return f"{where}: {moments}; {why}"


def read_placement(row: Mapping[str, Any], where: str) -> pin.SE3:
    """Placement from `origin` [m] and either `rotation` (3 x 3) or `rpy` [rad]."""
    origin = numbers(row.get("origin", [0.0] * 3), 3, f"{where} origin")
    if "rotation" in row and "rpy" in row:
        raise RobotError(f"{where}: rotation and rpy have the same meaning; give one of them")
    if "rotation" not in row:
        return pin.SE3(pin.rpy.rpyToMatrix(numbers(row.get("rpy", [0.0] * 3), 3, f"{where} rpy")), origin)
    rotation = matrix(row["rotation"], 3, f"{where} rotation")
    # 1e-6 allows for the digits that people type; a larger difference is a wrong number
    if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6) or np.linalg.det(rotation) < 0:
        raise RobotError(f"{where} rotation: {rotation.tolist()} is not a rotation matrix")
    return pin.SE3(rotation, origin)


def add_joint(
    model: pin.Model, parent: int, joint: pin.JointModel, placement: pin.SE3, name: str, link: str
) -> int:
    """Add a joint, and the frames of joint and link, which viewers find by name; return the joint's index."""
    if name in tuple(model.names):
        raise BrokenTree(f"two joints are called '{name}'; give each its own name")
    if model.existBodyName(link):
        raise BrokenTree(f"two links are called '{link}'; give each its own name")
    links = [
        i for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY and f.parentJoint == parent
    ]
    index = int(model.addJoint(parent, joint, placement, name))
    model.addJointFrame(index, links[0] if links else 0)
    model.addBodyFrame(link, index, pin.SE3.Identity(), model.getFrameId(name, pin.FrameType.JOINT))
    return index


def named_flange(
    model: pin.Model, placements: Mapping[str, pin.SE3], names: Sequence[str]
) -> tuple[pin.SE3, str]:
    """Placement whose name ends in one of `names`, the most likely first, and its name; or the last link."""
    for ending in names:
        for name, placement in placements.items():
            if name.lower().endswith(ending):
                return pin.SE3(placement), name
    return pin.SE3.Identity(), link_frames(model)[-1].child


def link_kinematics(rows: Sequence[Mapping[str, Any]], name: str) -> Kinematics:
    """Tree from `[[link]]` rows: a joint, its placement in its parent's frame, and the body it moves."""
    model = pin.Model()
    model.name = name
    for place, row in enumerate(rows):
        where = f"link {place + 1}"
        check_keys(row, KEYS["[[link]]"], where)
        joint = string(row.get("joint", f"joint{place + 1}"), f"{where} joint")
        where = f"link of {joint}"
        parent = _parent(row.get("parent"), tuple(model.names), name)
        kind = row.get("kind", "revolute")
        if kind not in KINDS:
            raise RobotError(f"{where}: unknown kind {kind!r}. Valid kinds: {', '.join(KINDS)}")
        link = string(row.get("link", f"link{place + 1}"), f"{where} link")
        index = add_joint(
            model, parent, joint_model(kind, _axis(row, where)), read_placement(row, where), joint, link
        )
        mass = number(row.get("mass", 0.0), f"{where} mass")
        center = numbers(row.get("center_of_mass", [0.0] * 3), 3, f"{where} center_of_mass")
        inertia = numbers(row.get("inertia", [0.0] * 6), 6, f"{where} inertia")
        # not appendBodyToJoint, which adds and rotates and so loses the last digits
        model.inertias[index] = rigid_inertia(mass, center, inertia, where)
    return Kinematics(model, doubts=body_doubts(model), flange_name=link)


def body_doubts(model: pin.Model) -> tuple[str, ...]:
    """Doubts about the inertia of the body that each joint moves."""
    bodies = zip(list(model.names)[1:], list(model.inertias)[1:], strict=True)
    doubts = (inertia_doubt(body.inertia, f"body moved by joint '{joint}'") for joint, body in bodies)
    return tuple(doubt for doubt in doubts if doubt)


def joint_model(kind: str, axis: np.ndarray) -> pin.JointModel:
    """Pinocchio joint about or along a unit axis (3,)."""
    along_z = bool(np.array_equal(axis, [0.0, 0.0, 1.0]))
    if kind == "revolute":
        return pin.JointModelRZ() if along_z else pin.JointModelRevoluteUnaligned(axis)
    return pin.JointModelPZ() if along_z else pin.JointModelPrismaticUnaligned(axis)


def _parent(parent: object, names: tuple[str, ...], robot: str) -> int:
    """Index of the parent joint of a row: the joint before it, unless the row names another."""
    if parent is None:
        return len(names) - 1
    if parent == "":
        return 0
    if parent not in names[1:]:
        raise UnknownJoint(parent, f"{robot}, above the row that names it as its parent,", names[1:])
    return names.index(str(parent))


def _axis(row: Mapping[str, Any], where: str) -> np.ndarray:
    axis = numbers(row.get("axis", [0.0, 0.0, 1.0]), 3, f"{where} axis")
    length = float(np.linalg.norm(axis))
    if length == 0.0:
        raise RobotError(f"{where} axis: a direction of length 0")
    # an axis that is already a unit vector keeps all digits
    return axis if abs(length - 1.0) < 1e-12 else axis / length
