"""Patch of the user's URDF: identified numbers are written, and every other byte stays the same.

Fixed links keep their inertia, see `bodies`; only the link that a joint moves changes. The arm that is read
from the new text is compared with the identified one before it is returned.
"""

from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np
import pinocchio as pin

from ..effects.rigid_body import body_inertia, inertial_parameters
from ..errors import RobotError
from ..fit.identified import Standard
from ..robot_files.kinematics import INERTIA_PLACES, inertia_matrix
from ..robot_files.mjcf_elements import JOINT_TERMS
from ..robot_files.urdf import parse_urdf
from ..robot_files.urdf_checks import numbers_of
from .bodies import PLACES, body_numbers, differ, fixed_share, number_changes, robot_bodies
from .changes import Change, Spread, nearly_equal, number_words
from .mjcf_patch import Patch, sentences_left_out
from .portable import Portable
from .texts import IN_URDF
from .xml_text import Edits, Tag, element_text, read_tags

DYNAMICS = {"damping": "damping", "dry": "friction"}
"""Term of a joint -> attribute of <dynamics>."""


def patch_urdf(portable: Portable, standard: Standard, text: bytes, where: str) -> Patch:
    """Write the identified numbers to the text of a URDF; `where` is its name in errors."""
    robot, edits, spread = portable.robot, Edits(text), Spread(portable.model, standard)
    tags = read_tags(text, where).children
    links, joints = (
        {t.attributes.get("name", ""): t for t in tags if t.name == k} for k in ("link", "joint")
    )
    if missing := [name for name in robot.joints if name not in joints]:
        raise RobotError(f"{where} has no joint {', '.join(missing)}; it describes another arm")
    old, new = _bodies(text, portable, where), robot_bodies(robot)
    largest = max(float(np.max(np.abs(new))), np.finfo(float).tiny)
    changes: list[Change] = []
    for place, name in enumerate(robot.joints):
        changes += _joint_changes(portable, place, joints[name], spread, edits)
        link = _Link(links[_child(joints[name], "child").attributes["link"]])
        if differ(old[place], new[place]):
            fixed = old[place] - link.ten
            if link.inertial.name and fixed_share(old[place], new[place], fixed, largest) < 1.0:
                raise RobotError(
                    f"{where}: links fixed to '{link.name}' weigh more than all of them together as "
                    "identified. Correct their masses, or omit --patch"
                )
            changes += link.changes(new[place] - fixed, fixed, spread, place)
            link.write(link.numbers(new[place] - fixed), edits)
    if np.any(np.abs(_bodies(edits.text(), portable, where) - new) > 1e-6 * largest):
        raise RobotError(f"{where}: an <inertial> is stated twice; remove one")
    left_out = sentences_left_out(portable, spread, (*IN_URDF, "uncertainty"))
    return Patch(edits.text(), tuple(changes), tuple(left_out))


def _bodies(text: bytes, portable: Portable, where: str) -> np.ndarray:
    """Ten parameters of what each joint of the robot moves, shape (n, 10)."""
    robot = portable.robot
    model = parse_urdf(text.decode(), where, robot.joints, robot.held).model
    return np.array([inertial_parameters(model.inertias[model.getJointId(name)]) for name in robot.joints])


def _child(tag: Tag, name: str) -> Tag:
    """The first element of a name in a tag; an empty one if there is none."""
    return next((child for child in tag.children if child.name == name), Tag("", -1, {}))


def _joint_changes(
    portable: Portable, place: int, joint: Tag, spread: Spread, edits: Edits
) -> Iterator[Change]:
    """Write damping and friction of a joint, and yield the changes."""
    dynamics, words = _child(joint, "dynamics"), {}
    for term, attribute in DYNAMICS.items():
        before = float(dynamics.attributes.get(attribute, 0.0))
        now = float(getattr(portable.joints, term)[place])
        if not nearly_equal(before, now):
            words[attribute] = number_words([now])
            where, unit = f"joint '{joint.attributes['name']}'", JOINT_TERMS[term].unit
            half = spread.half(place, term)
            yield Change(where, attribute, portable.robot.unit(place, unit), before, now, half)
    _write(edits, joint, "dynamics", words)


def _write(edits: Edits, parent: Tag, name: str, words: Mapping[str, str]) -> None:
    """Set attributes of an element, which is added to its parent if it does not exist."""
    if tag := next((child for child in parent.children if child.name == name), None):
        edits.set(tag, **words)
    elif words:
        edits.add_inside(parent, element_text(name, words))


class _Link:
    """The <inertial> of a link; the axes of its inertia stay those of the file."""

    def __init__(self, link: Tag) -> None:
        self.tag, self.name, self.inertial = link, link.attributes["name"], _child(link, "inertial")
        self.origin, self.mass, self.inertia = map(
            partial(_child, self.inertial), ("origin", "mass", "inertia")
        )
        self.axes = pin.rpy.rpyToMatrix(numbers_of(self.origin.attributes.get("rpy", "0 0 0")))

    @property
    def ten(self) -> np.ndarray:
        """Ten parameters in the frame of the link, shape (10,)."""
        mass = float(self.mass.attributes.get("value", 0.0))
        elements = np.array([float(self.inertia.attributes.get(f"i{axes}", 0.0)) for axes in INERTIA_PLACES])
        center = numbers_of(self.origin.attributes.get("xyz", "0 0 0"))
        turned = self.axes @ inertia_matrix(elements) @ self.axes.T
        return inertial_parameters(pin.Inertia(mass, center, turned))

    def numbers(self, ten: np.ndarray) -> np.ndarray:
        """Mass, center and inertia as the file has them, shape (10,)."""
        body = body_inertia(ten)
        return body_numbers(body.mass, body.lever, self.axes.T @ body.inertia @ self.axes)

    def changes(self, ten: np.ndarray, fixed: np.ndarray, spread: Spread, place: int) -> Iterator[Change]:
        """Changes to ten parameters; `fixed` (10,) are those of links fixed to it."""
        old = self.numbers(self.ten) if self.inertial.name else np.zeros(10)
        halves = spread.of_body(place, lambda values: self.numbers(values - fixed))
        return number_changes(f"link '{self.name}'", "origin", "inertia i", old, self.numbers(ten), halves)

    def write(self, numbers: np.ndarray, edits: Edits) -> None:
        """Write its ten numbers."""
        elements = zip((f"i{axes}" for axes in PLACES), number_words(numbers[4:]).split(), strict=True)
        parts = {
            "origin": {"xyz": number_words(numbers[1:4])}, "mass": {"value": number_words(numbers[:1])},
            "inertia": dict(elements),
        }  # fmt: skip
        if not self.inertial.name:
            inside = "".join(element_text(name, attributes) for name, attributes in parts.items())
            edits.add_inside(self.tag, f"<inertial>{inside}</inertial>")
        for name, attributes in parts.items() if self.inertial.name else ():
            _write(edits, self.inertial, name, attributes)
