"""Bodies in an MJCF: identified mass, center and inertia of what each joint moves.

A joint may move several bodies that are fixed to each other, of which only the sum is identified. The body
with the joint gets the difference, and the bodies fixed to it stay as they are. If they exceed the sum, they
are scaled: by the ratio of new and old mass, but at most by half of what would leave nothing for the body.
"""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from ..effects.rigid_body import body_inertia, inertial_parameters
from ..fit.estimators.consistent import pseudo_inertia
from ..robot_files.mjcf import Part, own_inertia
from ..robot_files.mjcf_names import name_of
from .mjcf_changes import SAME, Change, File, number_words, sizes
from .portable import Portable, possible
from .spread import Spread
from .xml_text import Edits, element_text

OTHER_FORMS = ("quat", "axisangle", "euler", "xyaxes", "zaxis", "diaginertia")
"""Attributes of an <inertial> that are alternatives to `fullinertia`."""
PLACES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
"""Matrix indices of the numbers in `fullinertia`, in its order."""
NUMBERS = (
    ("mass", "kg"), *((f"pos {axis}", "m") for axis in "xyz"),
    *((f"fullinertia {pair}", "kg m^2") for pair in PLACES),
)  # fmt: skip
"""Attribute and unit of the ten numbers of a body, in the order of `_numbers`."""


def body_changes(file: File, portable: Portable, spread: Spread, edits: Edits) -> Iterator[Change]:
    """Write the bodies that joints move, and yield the changes."""
    new = [inertial_parameters(body) for body in list(portable.robot.kinematics.inertias)[1:]]
    old = [inertial_parameters(body) for body in list(file.nominal.robot.kinematics.inertias)[1:]]
    largest = max(float(np.max(np.abs(new))), np.finfo(float).tiny)
    for link in range(len(new)):
        if np.all(np.abs(new[link] - old[link]) <= SAME * sizes(new[link])):
            continue
        body = int(file.compiled.jnt_bodyid[file.joints[link]])
        if file.parts[body].joint != link + 1:  # one of several joints of the same body, without its own mass
            continue
        fixed = [other for other, part in enumerate(file.parts) if part.joint == link + 1 and other != body]
        fixed = [other for other in fixed if file.compiled.body_mass[other] > 0.0]
        share = fixed_share(old[link], new[link], _sum(file, fixed), largest)
        for other in fixed if share < 1.0 else ():
            scaled = share * _ten(file, other)
            yield from _changed(file, other, scaled, np.full(len(NUMBERS), np.inf), edits)
        rest = new[link] - share * _sum(file, fixed)
        constant = share * _sum(file, fixed)
        halves = spread.of_body(link, lambda ten: _numbers(ten - constant, file.parts[body]))  # noqa: B023
        yield from _changed(file, body, rest, halves, edits)


def fixed_share(old: np.ndarray, new: np.ndarray, fixed: np.ndarray, largest: float) -> float:
    """Share that bodies fixed to a body keep, such that a body with positive mass and inertia is left.

    Parameters (10,) are those of all these bodies together in the file and as identified, and those of the
    fixed bodies in the file; `largest` is the largest of all bodies of the arm.
    """
    rest = new - fixed
    if not np.any(fixed) or np.all(possible(rest, largest) == rest):
        return 1.0
    shares = np.linalg.eigvals(np.linalg.solve(pseudo_inertia(new), pseudo_inertia(fixed))).real
    return float(min(new[9] / old[9], 0.5 / max(shares)))


def _changed(file: File, body: int, ten: np.ndarray, halves: np.ndarray, edits: Edits) -> Iterator[Change]:
    """Write ten parameters of a body, in the frame of its joint, and yield the changes.

    `halves` (10,) are the halves of the 95 % intervals of its numbers.
    """
    numbers, original = (_numbers(values, file.parts[body]) for values in (ten, _ten(file, body)))
    _write_body(file, body, numbers, edits)
    where = f"body '{name_of(file.compiled, 'body', body)}'"
    for (attribute, unit), scale, old, new, half in zip(
        NUMBERS, number_scales(numbers), original, numbers, halves, strict=True
    ):
        if abs(new - old) > SAME * scale:
            before = 0.0 if abs(old) <= SAME * scale else float(old)  # MuJoCo's rounding
            yield Change(where, attribute, unit, before, float(new), float(half))


def _sum(file: File, bodies: list[int]) -> np.ndarray:
    """Ten parameters of several bodies together, in the frame of their joint."""
    return np.sum([np.zeros(10), *(_ten(file, body) for body in bodies)], axis=0)


def _ten(file: File, body: int) -> np.ndarray:
    """Ten parameters of a body in the file, in the frame of its joint."""
    return inertial_parameters(file.parts[body].placement.act(own_inertia(file.compiled, body)))


def _numbers(values: np.ndarray, part: Part) -> np.ndarray:
    """Mass, center and inertia in the body frame, from ten parameters in the joint frame, shape (10,)."""
    body: pin.Inertia = part.placement.actInv(body_inertia(values))
    return np.array([body.mass, *body.lever, *(body.inertia[place] for place in PLACES.values())])


def number_scales(numbers: np.ndarray) -> np.ndarray:
    """Scale of each of the ten numbers of a body, from its mass and extent, shape (10,)."""
    mass, moments = numbers[0], float(np.sum(numbers[4:7]))
    reach = np.sqrt(moments / mass) + np.linalg.norm(numbers[1:4])
    return np.array([mass] + [reach] * 3 + [moments] * 6)


def _write_body(file: File, body: int, numbers: np.ndarray, edits: Edits) -> None:
    words = {
        "pos": number_words(numbers[1:4]), "mass": number_words(numbers[:1]),
        "fullinertia": number_words(numbers[4:]),
    }  # fmt: skip
    tag = file.elements.body(body)
    inertial = next((child for child in tag.children if child.name == "inertial"), None)
    if inertial is None:
        edits.add_inside(tag, element_text("inertial", words))
    else:
        edits.set(inertial, **words, **dict.fromkeys(OTHER_FORMS))
        if "diaginertia" in inertial.attributes:
            edits.set(inertial, fullinertia=None)
            edits.replace(inertial, "diaginertia", "fullinertia", words["fullinertia"])
