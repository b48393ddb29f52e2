"""Changed numbers in an MJCF, and edits that write them to its text."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from exidyn.quoting import xml_attribute

from ..effects.rigid_body import body_inertia, inertial_parameters
from ..errors import RobotError
from ..model import Model
from ..robot_files.mjcf import Part, own_inertia
from ..robot_files.mjcf_names import name_of
from .mjcf_elements import Elements
from .portable import Portable, possible
from .spread import Spread, changed_by
from .xml_text import Edits

TERMS = {
    "armature": ("armature", "kg m^2"),
    "damping": ("damping", "N m s/rad"),
    "dry": ("frictionloss", "N m"),
    "stiffness": ("stiffness", "N m/rad"),
}
"""Term of a joint -> attribute, and unit for revolute joints."""
SAME = 1e-6
"""Relative difference within which a number is unchanged: rounding in computation and in the file."""
DIGITS = 8
"""Number of significant digits in the file."""
OTHER_FORMS = ("quat", "axisangle", "euler", "xyaxes", "zaxis", "diaginertia")
"""Attributes of an <inertial> that are alternatives to `fullinertia`."""
PLACES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
"""Matrix indices of the numbers in `fullinertia`, in its order."""
NUMBERS = (
    ("mass", "kg"), *((f"pos {axis}", "m") for axis in "xyz"),
    *((f"fullinertia {pair}", "kg m^2") for pair in PLACES),
)  # fmt: skip
"""Attribute and unit of the ten numbers of a body, in the order of `_numbers`."""


class Change(NamedTuple):
    """A changed number of the file.

    Attributes:
        where: Element, such as "joint 'elbow'".
        attribute: Attribute, such as "damping" or "pos x".
        unit: SI unit.
        old: Number in the file, or the one that MuJoCo computed from the file.
        new: New number.
        half: Half of its 95 % interval; infinite if unknown.
    """

    where: str
    attribute: str
    unit: str
    old: float
    new: float
    half: float

    @property
    def told_apart(self) -> bool:
        """Whether the old number is outside the interval."""
        return abs(self.new - self.old) > self.half


@dataclass(frozen=True, eq=False)
class File:
    """The MJCF before the changes.

    Attributes:
        where: Name of the file in errors.
        elements: Elements of its text.
        compiled: Model that MuJoCo compiles from it.
        joints: Index of each robot joint in the compiled model.
        parts: Place of each body of the compiled model in the robot.
        nominal: Model of the robot that it describes.
    """

    where: str
    elements: Elements
    compiled: Any
    joints: list[int]
    parts: list[Part]
    nominal: Model


def nearly_equal(old: float, new: float) -> bool:
    """Whether two numbers are equal except for rounding."""
    return abs(new - old) <= SAME * max(abs(old), abs(new))


def _words(values: Iterable[float]) -> str:
    numbers = np.array(list(values))
    numbers[np.abs(numbers) < 10.0**-DIGITS * np.abs(numbers).max()] = 0.0  # rounding
    return " ".join(f"{value:.{DIGITS}g}" for value in numbers)


def joint_changes(file: File, portable: Portable, spread: Spread, edits: Edits) -> Iterator[Change]:
    """Write the terms of all joints, and yield the changes."""
    old, new, robot = Portable.of(file.nominal).joints, portable.joints, portable.robot
    for place, (joint, name) in enumerate(zip(file.joints, robot.joints, strict=True)):
        tag, where = file.elements.joint(joint), f"joint '{name}'"
        for term, (attribute, unit) in TERMS.items():
            before, now = getattr(old, term)[place], getattr(new, term)[place]
            if not nearly_equal(before, now):
                of_joint = now - _of_actuator(file, joint, attribute, before)
                if of_joint < 0.0 and now >= 0.0:
                    raise RobotError(
                        f"{file.where}: the actuator of joint '{name}' has more {attribute} than the "
                        f"identified {now:.4g} of joint and actuator. Remove it from the actuator"
                    )
                edits.set(tag, **{attribute: _words([of_joint])})
                half = spread.half(place, term)
                yield Change(where, attribute, robot.unit(place, unit), float(before), float(now), half)
        if stiffness := new.stiffness[place]:
            reference, before = -new.constant[place] / stiffness, _spring_reference(file, joint)
            if not nearly_equal(before, reference):
                degrees = robot.revolute[place] and file.elements.degrees
                edits.set(tag, springref=_words([np.degrees(reference) if degrees else reference]))
                gradient = -reference / stiffness, -1.0 / stiffness
                half = changed_by(gradient, spread.of_joint(place, "stiffness", "constant"))
                yield Change(where, "springref", robot.unit(place, "rad"), before, float(reference), half)


def _spring_reference(file: File, joint: int) -> float:
    """Rest position of a joint's spring in the file [rad, m]."""
    return float(file.compiled.qpos_spring[file.compiled.jnt_qposadr[joint]])


def _of_actuator(file: File, joint: int, attribute: str, total: float) -> float:
    """Share of the actuator in the total armature or damping of a joint."""
    if attribute not in ("armature", "damping"):
        return 0.0
    of_joint = getattr(file.compiled, f"dof_{attribute}")[file.compiled.jnt_dofadr[joint]]
    return float(total - of_joint) if total else 0.0


def body_changes(file: File, portable: Portable, spread: Spread, edits: Edits) -> Iterator[Change]:
    """Write the bodies that joints move, and yield the changes; bodies fixed to them stay unchanged."""
    new = [inertial_parameters(body) for body in list(portable.robot.kinematics.inertias)[1:]]
    old = [inertial_parameters(body) for body in list(file.nominal.robot.kinematics.inertias)[1:]]
    largest = max(float(np.max(np.abs(new))), np.finfo(float).tiny)
    for link, name in enumerate(portable.robot.joints):
        if np.all(np.abs(new[link] - old[link]) <= SAME * sizes(new[link])):
            continue
        body = int(file.compiled.jnt_bodyid[file.joints[link]])
        if file.parts[body].joint != link + 1:  # one of several joints of the same body, without its own mass
            continue
        fixed = _fixed(file, body)
        values = new[link] - fixed
        if np.any(possible(values, largest) != values):
            raise RobotError(
                f"{file.where}: the identified mass or inertia behind joint '{name}' is less than that of "
                f"the bodies fixed to '{name_of(file.compiled, 'body', body)}'. Add their masses to that "
                "body, and remove theirs"
            )
        numbers = _numbers(values, file.parts[body])
        _write_body(file, body, numbers, edits)
        before = _numbers(_ten(file, body), file.parts[body])
        halves = spread.of_body(link, lambda ten: _numbers(ten - fixed, file.parts[body]))  # noqa: B023
        where = f"body '{name_of(file.compiled, 'body', body)}'"
        scales = _scales(numbers)
        for (attribute, unit), scale, *row in zip(NUMBERS, scales, before, numbers, halves, strict=True):
            if abs(row[1] - row[0]) > SAME * scale:
                yield Change(where, attribute, unit, *map(float, row))


def sizes(values: np.ndarray) -> np.ndarray:
    """Scale of each of ten parameters, from the mass and its distance from the frame, shape (10,)."""
    mass, squares = abs(values[9]), abs(values[0]) + abs(values[3]) + abs(values[5])
    return np.array([squares] * 6 + [np.sqrt(mass * squares)] * 3 + [mass]) + np.finfo(float).tiny


def _fixed(file: File, body: int) -> np.ndarray:
    """Ten parameters of all bodies fixed to a body, in the frame of its joint."""
    joint = file.parts[body].joint
    others = [other for other, part in enumerate(file.parts) if part.joint == joint and other != body]
    return np.sum([np.zeros(10), *(_ten(file, other) for other in others)], axis=0)


def _ten(file: File, body: int) -> np.ndarray:
    """Ten parameters of a body in the file, in the frame of its joint."""
    return inertial_parameters(file.parts[body].placement.act(own_inertia(file.compiled, body)))


def _numbers(values: np.ndarray, part: Part) -> np.ndarray:
    """Mass, center and inertia in the body frame, from ten parameters in the joint frame, shape (10,)."""
    body: pin.Inertia = part.placement.actInv(body_inertia(values))
    return np.array([body.mass, *body.lever, *(body.inertia[place] for place in PLACES.values())])


def _scales(numbers: np.ndarray) -> np.ndarray:
    """Scale of each of the ten numbers of a body, from its mass and extent, shape (10,)."""
    mass, moments = numbers[0], float(np.sum(numbers[4:7]))
    reach = np.sqrt(moments / mass) + np.linalg.norm(numbers[1:4])
    return np.array([mass] + [reach] * 3 + [moments] * 6)


def _write_body(file: File, body: int, numbers: np.ndarray, edits: Edits) -> None:
    words = {
        "pos": _words(numbers[1:4]), "mass": _words(numbers[:1]), "fullinertia": _words(numbers[4:]),
    }  # fmt: skip
    tag = file.elements.body(body)
    inertial = next((child for child in tag.children if child.name == "inertial"), None)
    if inertial is None:
        attributes = " ".join(f"{name}={xml_attribute(value)}" for name, value in words.items())
        edits.add_inside(tag, f"<inertial {attributes}/>")
    else:
        edits.set(inertial, **words, **dict.fromkeys(OTHER_FORMS))
        if "diaginertia" in inertial.attributes:
            edits.set(inertial, fullinertia=None)
            edits.replace(inertial, "diaginertia", "fullinertia", words["fullinertia"])


def change_gravity(file: File, portable: Portable, edits: Edits) -> list[str]:
    """Write gravity unless the file compensates it; returns sentences on what is not changed."""
    old, new = file.nominal.robot.gravity, portable.robot.gravity
    if np.all(np.abs(old - new) <= SAME * np.linalg.norm(new)):
        return []
    stated = ", ".join(f"{part:.4g}" for part in new)
    if np.any(file.compiled.body_gravcomp) or not np.allclose(old, file.compiled.opt.gravity):
        return [f"gravity of {stated} m/s^2: the file compensates or disables it, and is not changed"]
    options = [child for child in file.elements.root.children if child.name == "option"]
    if options:
        edits.set(options[-1], gravity=_words(new))
    else:
        edits.add_inside(file.elements.root, f"<option gravity={xml_attribute(_words(new))}/>")
    return []
