"""Patch of the user's URDF: identified numbers are written, and every other byte stays the same.

Fixed links keep their inertia, as in `mjcf_bodies`; only the link that a joint moves changes. The arm that is
read from the new text is compared with the identified one before it is returned.
"""

from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np
import pinocchio as pin

from ..effects.rigid_body import body_inertia, inertial_parameters
from ..errors import RobotError
from ..fit.identified import Standard
from ..robot_files.kinematics import INERTIA_PLACES, inertia_matrix
from ..robot_files.urdf import parse_urdf
from ..robot_files.urdf_checks import numbers_of
from .mjcf_bodies import PLACES, fixed_share, number_scales
from .mjcf_changes import SAME, Change, nearly_equal, number_words, sizes
from .mjcf_patch import Patch, sentences_left_out
from .portable import Portable
from .spread import Spread
from .texts import IN_URDF
from .xml_text import Edits, Tag, element_text, read_tags

DYNAMICS = {"damping": ("damping", "N m s/rad"), "dry": ("friction", "N m")}
"""Term of a joint -> attribute of <dynamics>, and unit for revolute joints."""
NUMBERS = (
    ("mass", "kg"), *((f"origin {axis}", "m") for axis in "xyz"),
    *((f"inertia i{axes}", "kg m^2") for axes in PLACES),
)  # fmt: skip
"""Element and unit of the ten numbers of a link, in the order of `_numbers`."""


def patch_urdf(portable: Portable, standard: Standard, text: bytes, where: str) -> Patch:
    """Write the identified numbers to the text of a URDF; `where` is its name in errors."""
    robot, edits, spread = portable.robot, Edits(text), Spread(portable.model, standard)
    tags = read_tags(text, where).children
    links, joints = (
        {t.attributes.get("name", ""): t for t in tags if t.name == k} for k in ("link", "joint")
    )
    if missing := [name for name in robot.joints if name not in joints]:
        raise RobotError(f"{where} has no joint {', '.join(missing)}; it describes another arm")
    old = _bodies(text, portable, where)
    new = [inertial_parameters(body) for body in list(robot.kinematics.inertias)[1:]]
    largest = max(float(np.max(np.abs(new))), np.finfo(float).tiny)
    changes: list[Change] = []
    for place, name in enumerate(robot.joints):
        changes += _joint_changes(portable, place, joints[name], spread, edits)
        link = _Link(links[_child(joints[name], "child").attributes["link"]])
        if np.any(np.abs(new[place] - old[place]) > SAME * sizes(new[place])):
            fixed = old[place] - link.ten
            if link.inertial.name and fixed_share(old[place], new[place], fixed, largest) < 1.0:
                raise RobotError(
                    f"{where}: links fixed to '{link.tag.attributes['name']}' weigh more than all of them "
                    "together as identified. Correct their masses, or omit --patch"
                )
            changes += _link_changes(link, new[place] - fixed, fixed, spread, place)
            link.write(link.numbers(new[place] - fixed), edits)
    written = _bodies(edits.text(), portable, where)
    if any(np.any(np.abs(a - b) > 1e-6 * largest) for a, b in zip(written, new, strict=True)):
        raise RobotError(f"{where}: an <inertial> is stated twice; remove one")
    left_out = sentences_left_out(portable, spread, (*IN_URDF, "uncertainty"))
    return Patch(edits.text(), tuple(changes), tuple(left_out))


def _bodies(text: bytes, portable: Portable, where: str) -> list[np.ndarray]:
    """Ten parameters of what each joint moves, each (10,)."""
    robot = portable.robot
    model = parse_urdf(text.decode(), where, robot.joints, robot.held).model
    return [inertial_parameters(model.inertias[model.getJointId(name)]) for name in robot.joints]


def _child(tag: Tag, name: str) -> Tag:
    """The first element of a name in a tag; an empty one if there is none."""
    return next((child for child in tag.children if child.name == name), Tag("", -1, {}))


def _joint_changes(
    portable: Portable, place: int, joint: Tag, spread: Spread, edits: Edits
) -> Iterator[Change]:
    """Write damping and friction of a joint, and yield the changes."""
    dynamics, words = _child(joint, "dynamics"), {}
    for term, (attribute, unit) in DYNAMICS.items():
        before = float(dynamics.attributes.get(attribute, 0.0))
        now = float(getattr(portable.joints, term)[place])
        if not nearly_equal(before, now):
            words[attribute] = number_words([now])
            where = f"joint '{joint.attributes['name']}'"
            half = spread.half(place, term)
            yield Change(where, attribute, portable.robot.unit(place, unit), before, now, half)
    _write(edits, joint, "dynamics", words)


def _link_changes(
    link: "_Link", ten: np.ndarray, fixed: np.ndarray, spread: Spread, place: int
) -> Iterator[Change]:
    """Changes of a link to ten parameters; `fixed` (10,) are those of links fixed to it."""
    old, new = link.numbers(link.ten) if link.inertial.name else np.zeros(10), link.numbers(ten)
    halves = spread.of_body(place, lambda values: link.numbers(values - fixed))
    where = f"link '{link.tag.attributes['name']}'"
    for (attribute, unit), *numbers, scale in zip(NUMBERS, old, new, halves, number_scales(new), strict=True):
        before, now, half = map(float, numbers)
        if abs(now - before) > SAME * scale:
            yield Change(where, attribute, unit, before, now, half)


def _write(edits: Edits, parent: Tag, name: str, words: Mapping[str, str]) -> None:
    """Set attributes of an element, which is added to its parent if it does not exist."""
    if tag := next((child for child in parent.children if child.name == name), None):
        edits.set(tag, **words)
    elif words:
        edits.add_inside(parent, element_text(name, words))


class _Link:
    """The <inertial> of a link; the axes of its inertia stay those of the file."""

    def __init__(self, link: Tag) -> None:
        self.tag, self.inertial = link, _child(link, "inertial")
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
        turned = self.axes.T @ body.inertia @ self.axes
        return np.array([body.mass, *body.lever, *(turned[place] for place in PLACES.values())])

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
