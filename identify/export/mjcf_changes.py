"""Joint terms, bodies and gravity in the text of an MJCF: edits that write them, and the changed numbers."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..effects.rigid_body import body_inertia, inertial_parameters
from ..errors import RobotError
from ..model import Model
from ..robot_files.mjcf import Part, own_inertia
from ..robot_files.mjcf_elements import JOINT_TERMS, disabled, name_of
from .bodies import body_numbers, differ, fixed_share, number_changes, number_scales, robot_bodies
from .changes import DIGITS, SAME, Change, Spread, changed_by, nearly_equal, number_words
from .portable import Portable
from .xml_text import Edits, Elements, element_text

WHOLE = 1.05
"""Identified share of the weight that may still be all of it: torques are known to some percent."""
OTHER_FORMS = ("quat", "axisangle", "euler", "xyaxes", "zaxis", "diaginertia")
"""Attributes of an <inertial> that are alternatives to `fullinertia`."""


@dataclass(frozen=True, eq=False)
class File:
    """The MJCF before the changes."""

    where: str  # name of the file in errors
    elements: Elements  # elements of its text
    compiled: Any  # model that MuJoCo compiles from it
    joints: list[int]  # index of each robot joint in the compiled model
    parts: list[Part]  # place of each body of the compiled model in the robot
    nominal: Model  # model of the robot that it describes


def joint_changes(file: File, portable: Portable, spread: Spread, edits: Edits) -> Iterator[Change]:
    """Write the terms of all joints, and yield the changes."""
    old, new, robot = Portable.of(file.nominal).joints, portable.joints, portable.robot
    for place, (joint, name) in enumerate(zip(file.joints, robot.joints, strict=True)):
        tag, where = file.elements.tag("joint", joint), f"joint '{name}'"
        for term, number in JOINT_TERMS.items():
            before, now = float(getattr(old, term)[place]), float(getattr(new, term)[place])
            if nearly_equal(before, now):
                continue
            of_joint = now - _of_actuator(file, joint, term, before)
            if of_joint < 0.0 and now >= 0.0:
                raise RobotError(
                    f"{file.where}: the actuator of joint '{name}' has more {number.attribute} than the "
                    f"identified {now:.4g} of joint and actuator. Remove it from the actuator"
                )
            edits.set(tag, **{number.attribute: number_words([of_joint])})
            unit = robot.unit(place, number.unit)
            yield Change(where, number.attribute, unit, before, now, spread.half(place, term))
        if stiffness := new.stiffness[place]:
            reference = -new.constant[place] / stiffness
            before = float(file.compiled.qpos_spring[file.compiled.jnt_qposadr[joint]])
            if not nearly_equal(before, reference):
                degrees = robot.revolute[place] and file.elements.degrees
                edits.set(tag, springref=number_words([np.degrees(reference) if degrees else reference]))
                gradient = -reference / stiffness, -1.0 / stiffness
                half = changed_by(gradient, spread.of_joint(place, "stiffness", "constant"))
                yield Change(where, "springref", robot.unit(place, "rad"), before, float(reference), half)


def _of_actuator(file: File, joint: int, term: str, total: float) -> float:
    """Share of the actuator in the total armature or damping of a joint."""
    if term not in ("armature", "damping") or not total:
        return 0.0
    return total - JOINT_TERMS[term].read(file.compiled, file.compiled.jnt_dofadr[joint])


def body_changes(file: File, portable: Portable, spread: Spread, edits: Edits) -> Iterator[Change]:
    """Write the bodies that joints move, see `bodies`, and yield the changes."""
    new, old = robot_bodies(portable.robot), robot_bodies(file.nominal.robot)
    largest = max(float(np.max(np.abs(new))), np.finfo(float).tiny)
    for link in range(len(new)):
        body = int(file.compiled.jnt_bodyid[file.joints[link]])
        # The first of several joints of a body moves no mass of its own.
        if not differ(old[link], new[link]) or file.parts[body].joint != link + 1:
            continue
        fixed = [
            other
            for other, part in enumerate(file.parts)
            if part.joint == link + 1 and other != body and file.compiled.body_mass[other] > 0.0
        ]
        together = np.sum([np.zeros(10), *(_ten(file, other) for other in fixed)], axis=0)
        share = fixed_share(old[link], new[link], together, largest)
        for other in fixed if share < 1.0 else ():
            yield from _changed(file, other, share * _ten(file, other), np.full(10, np.inf), edits)
        constant, part = share * together, file.parts[body]
        halves = spread.of_body(link, lambda ten: _numbers(ten - constant, part))  # noqa: B023
        yield from _changed(file, body, new[link] - constant, halves, edits)


def _changed(file: File, body: int, ten: np.ndarray, halves: np.ndarray, edits: Edits) -> Iterator[Change]:
    """Write ten parameters of a body, in the frame of its joint, and yield the changes.

    `halves` (10,) are the halves of the 95 % intervals of its numbers.
    """
    new, old = (_numbers(values, file.parts[body]) for values in (ten, _ten(file, body)))
    words = {
        "pos": number_words(new[1:4]), "mass": number_words(new[:1]), "fullinertia": number_words(new[4:])
    }  # fmt: skip
    tag = file.elements.tag("body", body)
    inertial = next((child for child in tag.children if child.name == "inertial"), None)
    if inertial is None:
        edits.add_inside(tag, element_text("inertial", words))
    else:
        edits.set(inertial, **words, **dict.fromkeys(OTHER_FORMS))
        if "diaginertia" in inertial.attributes:
            edits.set(inertial, fullinertia=None)
            edits.replace(inertial, "diaginertia", "fullinertia", words["fullinertia"])
    old[np.abs(old) <= SAME * number_scales(new)] = 0.0  # MuJoCo's rounding
    where = f"body '{name_of(file.compiled, 'body', body)}'"
    yield from number_changes(where, "pos", "fullinertia ", old, new, halves)


def _ten(file: File, body: int) -> np.ndarray:
    """Ten parameters of a body in the file, in the frame of its joint."""
    return inertial_parameters(file.parts[body].placement.act(own_inertia(file.compiled, body)))


def _numbers(values: np.ndarray, part: Part) -> np.ndarray:
    """Ten numbers of a body in its own frame, from ten parameters in the joint frame, shape (10,)."""
    body = part.placement.actInv(body_inertia(values))
    return body_numbers(body.mass, body.lever, body.inertia)


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
        edits.set(file.elements.tag("body", body), gravcomp=f"{share:.{DIGITS}g}" if share else None)
        where, old = f"body '{name_of(file.compiled, 'body', body)}'", file.compiled.body_gravcomp[body]
        yield Change(where, "gravcomp", "-", float(old), share, np.inf if share else 0.0)


def compensated_share(file: File, gravity: np.ndarray) -> float | None:
    """The `gravcomp` of all links with which motors carry a gravity (3,) [m/s^2]; None if it stays."""
    model, full, old = file.compiled, file.compiled.opt.gravity, file.nominal.robot.gravity
    size = float(full @ full)
    if not size or disabled(model, "GRAVITY") or np.any(model.jnt_actgravcomp) or _same(old, gravity):
        return None
    carried, before = float(gravity @ full) / size, float(old @ full) / size
    along = _same(carried * full, gravity) and _same(before * full, old)
    return max(1.0 - carried, 0.0) if along and 0.0 <= carried <= WHOLE else None


def _same(old: np.ndarray, new: np.ndarray) -> bool:
    return bool(np.all(np.abs(old - new) <= SAME * max(np.linalg.norm(old), np.linalg.norm(new))))
