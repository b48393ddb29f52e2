"""What is another number in an MJCF now, and where that is written."""

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
"""Term of a joint -> attribute, and unit where it turns."""
SAME = 1e-6
"""Share of a number within which it is the one in the file: rounding of what made it, and of who wrote it."""
DIGITS = 8
"""Significant digits that are written."""
OTHER_FORMS = ("quat", "axisangle", "euler", "xyaxes", "zaxis", "diaginertia")
"""Attributes of an <inertial> that say in other ways what `fullinertia` does."""
PLACES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
"""Of the numbers of `fullinertia`, in its order."""
NUMBERS = (
    ("mass", "kg"), *((f"pos {axis}", "m") for axis in "xyz"),
    *((f"fullinertia {pair}", "kg m^2") for pair in PLACES),
)  # fmt: skip
"""The ten numbers of a body, as `_numbers` has them."""


class Change(NamedTuple):
    """A number of the file that is another one now.

    Attributes:
        where: The element, such as "joint 'elbow'".
        attribute: Such as "damping" or "pos x".
        unit: SI.
        old: In the file, or what MuJoCo made of it.
        new: Now.
        half: Half of its 95 % interval; infinite where nothing is known of it.
    """

    where: str
    attribute: str
    unit: str
    old: float
    new: float
    half: float

    @property
    def told_apart(self) -> bool:
        """Whether its interval leaves the old number out."""
        return abs(self.new - self.old) > self.half


@dataclass(frozen=True, eq=False)
class File:
    """The file as it is.

    Attributes:
        where: What errors call it.
        elements: Its text.
        compiled: What MuJoCo makes of it.
        joints: The robot's joints, by their numbers there.
        parts: Where its bodies are in the robot.
        nominal: The robot that it describes.
    """

    where: str
    elements: Elements
    compiled: Any
    joints: list[int]
    parts: list[Part]
    nominal: Model


def same(old: float, new: float) -> bool:
    """Whether a number is the one in the file."""
    return abs(new - old) <= SAME * max(abs(old), abs(new))


def _words(values: Iterable[float]) -> str:
    every = np.array(list(values))
    every[np.abs(every) < 10.0**-DIGITS * np.abs(every).max()] = 0.0  # rounding
    return " ".join(f"{value:.{DIGITS}g}" for value in every)


def joint_changes(file: File, portable: Portable, spread: Spread, edits: Edits) -> Iterator[Change]:
    """Write the terms of all joints."""
    old, new, robot = Portable.of(file.nominal).joints, portable.joints, portable.robot
    for place, (joint, name) in enumerate(zip(file.joints, robot.joints, strict=True)):
        tag, where = file.elements.joint(joint), f"joint '{name}'"
        for term, (attribute, unit) in TERMS.items():
            before, now = getattr(old, term)[place], getattr(new, term)[place]
            if not same(before, now):
                own = now - _of_actuator(file, joint, attribute, before)
                if own < 0.0 and now >= 0.0:
                    raise RobotError(
                        f"{file.where}: the actuator of joint '{name}' alone has more {attribute} than the "
                        f"{now:.4g} that was found. Take it off the actuator"
                    )
                edits.set(tag, **{attribute: _words([own])})
                half = spread.half(place, term)
                yield Change(where, attribute, robot.unit(place, unit), float(before), float(now), half)
        if stiffness := new.stiffness[place]:
            rest, before = -new.constant[place] / stiffness, _rest(file, joint)
            if not same(before, rest):
                degrees = robot.revolute[place] and file.elements.degrees
                edits.set(tag, springref=_words([np.degrees(rest) if degrees else rest]))
                gradient = -rest / stiffness, -1.0 / stiffness
                half = changed_by(gradient, spread.of_joint(place, "stiffness", "constant"))
                yield Change(where, "springref", robot.unit(place, "rad"), before, float(rest), half)


def _rest(file: File, joint: int) -> float:
    """Where the file has a joint's spring at rest [rad, m]."""
    return float(file.compiled.qpos_spring[file.compiled.jnt_qposadr[joint]])


def _of_actuator(file: File, joint: int, attribute: str, total: float) -> float:
    """What the joint's actuator has of its armature or damping."""
    if attribute not in ("armature", "damping"):
        return 0.0
    own = getattr(file.compiled, f"dof_{attribute}")[file.compiled.jnt_dofadr[joint]]
    return float(total - own) if total else 0.0


def body_changes(file: File, portable: Portable, spread: Spread, edits: Edits) -> Iterator[Change]:
    """Write the bodies that joints move; what is fixed to one stays as it is."""
    new = [inertial_parameters(one) for one in list(portable.robot.kinematics.inertias)[1:]]
    old = [inertial_parameters(one) for one in list(file.nominal.robot.kinematics.inertias)[1:]]
    largest = max(float(np.max(np.abs(new))), np.finfo(float).tiny)
    for link, name in enumerate(portable.robot.joints):
        if np.all(np.abs(new[link] - old[link]) <= SAME * sizes(new[link])):
            continue
        body = int(file.compiled.jnt_bodyid[file.joints[link]])
        if file.parts[body].joint != link + 1:  # one of several joints of one body, without a mass of its own
            continue
        fixed = _fixed(file, body)
        own = new[link] - fixed
        if np.any(possible(own, largest) != own):
            raise RobotError(
                f"{file.where}: what joint '{name}' moves is less than the bodies that are fixed to "
                f"'{name_of(file.compiled, 'body', body)}'. Give that body their masses, and leave theirs out"
            )
        numbers = _numbers(own, file.parts[body])
        _write_body(file, body, numbers, edits)
        before = _numbers(_ten(file, body), file.parts[body])
        halves = spread.of_body(link, lambda ten: _numbers(ten - fixed, file.parts[body]))  # noqa: B023
        where = f"body '{name_of(file.compiled, 'body', body)}'"
        scales = _scales(numbers)
        for (attribute, unit), scale, *values in zip(NUMBERS, scales, before, numbers, halves, strict=True):
            if abs(values[1] - values[0]) > SAME * scale:
                yield Change(where, attribute, unit, *map(float, values))


def sizes(values: np.ndarray) -> np.ndarray:
    """Sizes that ten parameters have by the mass and its distance from the frame, shape (10,)."""
    mass, squares = abs(values[9]), abs(values[0]) + abs(values[3]) + abs(values[5])
    return np.array([squares] * 6 + [np.sqrt(mass * squares)] * 3 + [mass]) + np.finfo(float).tiny


def _fixed(file: File, body: int) -> np.ndarray:
    """Ten parameters of what is fixed to a body, in the frame of its joint."""
    joint = file.parts[body].joint
    others = [other for other, part in enumerate(file.parts) if part.joint == joint and other != body]
    return np.sum([np.zeros(10), *(_ten(file, other) for other in others)], axis=0)


def _ten(file: File, body: int) -> np.ndarray:
    """Ten parameters of a body as it is in the file, in the frame of its joint."""
    return inertial_parameters(file.parts[body].placement.act(own_inertia(file.compiled, body)))


def _numbers(values: np.ndarray, part: Part) -> np.ndarray:
    """Mass, centre and inertia about it in a body's frame, of ten parameters in its joint's; shape (10,)."""
    own: pin.Inertia = part.placement.actInv(body_inertia(values))
    return np.array([own.mass, *own.lever, *(own.inertia[place] for place in PLACES.values())])


def _scales(numbers: np.ndarray) -> np.ndarray:
    """Sizes that the ten numbers of a body have, by its mass and extent, shape (10,)."""
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
    """Write gravity, unless bodies compensate it; what stays as it is, in sentences."""
    old, new = file.nominal.robot.gravity, portable.robot.gravity
    if np.all(np.abs(old - new) <= SAME * np.linalg.norm(new)):
        return []
    stated = ", ".join(f"{part:.4g}" for part in new)
    if np.any(file.compiled.body_gravcomp) or not np.allclose(old, file.compiled.opt.gravity):
        return [f"gravity of {stated} m/s^2: the file compensates or disables it, and stays as it is"]
    options = [child for child in file.elements.root.children if child.name == "option"]
    if options:
        edits.set(options[-1], gravity=_words(new))
    else:
        edits.add_inside(file.elements.root, f"<option gravity={xml_attribute(_words(new))}/>")
    return []
