"""Changed numbers in an MJCF, and edits that write them to its text."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import isclose
from typing import Any, NamedTuple

import numpy as np

from ..errors import RobotError
from ..model import Model
from ..robot_files.mjcf import Part
from ..robot_files.mjcf_names import disabled, name_of
from .portable import Portable
from .spread import Spread, changed_by
from .xml_text import Edits, Elements, element_text

TERMS = {
    "armature": ("armature", "kg m^2"),
    "damping": ("damping", "N m s/rad"),
    "dry": ("frictionloss", "N m"),
    "stiffness": ("stiffness", "N m/rad"),
}
"""Term of a joint -> attribute, and unit for revolute joints."""
SAME = 1e-6
"""Relative difference within which a number is unchanged: rounding in computation and in the file."""
WHOLE = 1.05
"""Identified share of the weight that may still be all of it: torques are known to some percent."""
DIGITS = 8
"""Number of significant digits in the file."""


class Change(NamedTuple):
    """A changed number of the file."""

    where: str  # element, such as "joint 'elbow'"
    attribute: str  # attribute, such as "damping" or "pos x"
    unit: str  # SI unit
    old: float  # number in the file, or the one that MuJoCo computed from the file
    new: float  # new number
    half: float  # half of its 95 % interval; infinite if unknown
    reason: str = ""  # why it changes, if it was not identified by itself

    @property
    def told_apart(self) -> bool:
        """Whether the old number is outside the interval."""
        return abs(self.new - self.old) > self.half


@dataclass(frozen=True, eq=False)
class File:
    """The MJCF before the changes."""

    where: str  # name of the file in errors
    elements: Elements  # elements of its text
    compiled: Any  # model that MuJoCo compiles from it
    joints: list[int]  # index of each robot joint in the compiled model
    parts: list[Part]  # place of each body of the compiled model in the robot
    nominal: Model  # model of the robot that it describes


def nearly_equal(old: float, new: float) -> bool:
    """Whether two numbers are equal except for rounding."""
    return isclose(old, new, rel_tol=SAME)


def number_words(values: Iterable[float]) -> str:
    """Text of numbers of one kind; those that are rounding errors of the largest are 0."""
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
                edits.set(tag, **{attribute: number_words([of_joint])})
                half = spread.half(place, term)
                yield Change(where, attribute, robot.unit(place, unit), float(before), float(now), half)
        if stiffness := new.stiffness[place]:
            reference = -new.constant[place] / stiffness
            before = float(file.compiled.qpos_spring[file.compiled.jnt_qposadr[joint]])
            if not nearly_equal(before, reference):
                degrees = robot.revolute[place] and file.elements.degrees
                edits.set(tag, springref=number_words([np.degrees(reference) if degrees else reference]))
                gradient = -reference / stiffness, -1.0 / stiffness
                half = changed_by(gradient, spread.of_joint(place, "stiffness", "constant"))
                yield Change(where, "springref", robot.unit(place, "rad"), before, float(reference), half)


def _of_actuator(file: File, joint: int, attribute: str, total: float) -> float:
    """Share of the actuator in the total armature or damping of a joint."""
    if attribute not in ("armature", "damping"):
        return 0.0
    of_joint = getattr(file.compiled, f"dof_{attribute}")[file.compiled.jnt_dofadr[joint]]
    return float(total - of_joint) if total else 0.0


def sizes(values: np.ndarray) -> np.ndarray:
    """Scale of each of ten parameters, from the mass and its distance from the frame, shape (10,)."""
    mass, squares = abs(values[9]), abs(values[0]) + abs(values[3]) + abs(values[5])
    return np.array([squares] * 6 + [np.sqrt(mass * squares)] * 3 + [mass]) + np.finfo(float).tiny


def change_gravity(file: File, portable: Portable, edits: Edits) -> tuple[list[Change], list[str]]:
    """Write gravity unless `gravcomp` or the mounting holds it; sentences say what is not changed."""
    old, new = file.nominal.robot.gravity, portable.robot.gravity
    if _same(old, new) or compensated_share(file, new) is not None:
        return [], []
    stated = ", ".join(f"{part:.4g}" for part in new)
    if np.any(file.compiled.body_gravcomp) or not np.allclose(old, file.compiled.opt.gravity):
        return [], [f"gravity of {stated} m/s^2: the file compensates or disables it, and is not changed"]
    options = [child for child in file.elements.root.children if child.name == "option"]
    if options:
        edits.set(options[-1], gravity=number_words(new))
    else:
        edits.add_inside(file.elements.root, element_text("option", {"gravity": number_words(new)}))
    tilt = float(np.degrees(np.arctan2(np.linalg.norm(np.cross(old, new)), old @ new)))
    return [Change("option", "gravity, angle from the file's", "deg", 0.0, tilt, np.inf)], []


def gravcomp_changes(file: File, portable: Portable, edits: Edits) -> Iterator[Change]:
    """Write the `gravcomp` with which motors carry as much of the weight as identified; yield the changes."""
    share = compensated_share(file, portable.robot.gravity)
    if share is None:
        return
    moved = np.array([part.joint > 0 for part in file.parts])
    loaded = moved & (file.compiled.body_mass > 0.0) & (share > 0.0)
    for body in map(int, np.flatnonzero(loaded | (file.compiled.body_gravcomp != 0.0))):
        edits.set(file.elements.body(body), gravcomp=f"{share:.{DIGITS}g}" if share else None)
        where, old = f"body '{name_of(file.compiled, 'body', body)}'", file.compiled.body_gravcomp[body]
        yield Change(where, "gravcomp", "-", float(old), share, np.inf if share else 0.0)


def compensated_share(file: File, gravity: np.ndarray) -> float | None:
    """The `gravcomp` of all links with which motors carry a gravity (3,) [m/s^2]; None if it stays."""
    model, full, old = file.compiled, file.compiled.opt.gravity, file.nominal.robot.gravity
    size = float(full @ full)
    if not size or disabled(model, "GRAVITY") or np.any(model.jnt_actgravcomp) or _same(old, gravity):
        return None
    left, before = float(gravity @ full) / size, float(old @ full) / size
    along = _same(left * full, gravity) and _same(before * full, old)
    return max(1.0 - left, 0.0) if along and 0.0 <= left <= WHOLE else None


def _same(old: np.ndarray, new: np.ndarray) -> bool:
    return bool(np.all(np.abs(old - new) <= SAME * max(np.linalg.norm(old), np.linalg.norm(new))))
