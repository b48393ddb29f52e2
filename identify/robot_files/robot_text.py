"""Write a model as one robot.toml that needs no other file, and reads back to the last digit."""

from dataclasses import fields
from typing import Any

import numpy as np
import pinocchio as pin

from ..arm.link_frames import link_frames
from ..arm.newton_euler import Joint, joints_of
from ..arm.robot import Robot
from ..effects import Effect, name_of
from ..model import Model
from .effect_rows import key_of
from .kinematics import INERTIA_PLACES
from .toml_text import block, lines

FORMAT = 1
RIGID_BODY = "link_inertia"
"""The effect that every arm has, so that files need not name it."""


def model_text(model: Model) -> str:
    """A robot.toml with the model's kinematics, limits, drives, effects and priors in it."""
    robot = model.robot
    head: dict[str, Any] = {
        "format": FORMAT,
        "name": robot.name,
        "gravity": robot.gravity,
    }
    if robot.inertias_stated:
        head["inertial_tolerance"] = robot.inertial_tolerance
    if not any(effect.of_links for effect in model.effects):
        head["rigid_body"] = False
    blocks = [lines(head), _limits(robot)]
    blocks += [block("[drive]", _drive(robot)), block("[flange]", _placement(robot.flange))]
    blocks += [block("[[link]]", link | _inertia(robot, i)) for i, link in enumerate(_links(robot))]
    written: set[str] = set()
    for place, effect in enumerate(model.effects):
        row = _effect_row(effect, model, written)
        if place or row != {"name": RIGID_BODY}:
            blocks.append(block("[[effect]]", row))
    single = {n: list(b) for n, b in model.stated.items() if n in model.names and n not in written}
    if single:
        blocks.append(block("[prior]", single))
    return "\n\n".join(blocks) + "\n"


def moving_text(robot: Robot) -> str:
    """The part of a robot.toml with geometry and limits, without masses."""
    blocks = [_limits(robot), block("[flange]", _placement(robot.flange))]
    return "\n\n".join([*blocks, *(block("[[link]]", link) for link in _links(robot))]) + "\n"


def _limits(robot: Robot) -> str:
    return block("[limits]", {f.name: getattr(robot.limits, f.name) for f in fields(robot.limits)})


def _drive(robot: Robot) -> dict[str, Any]:
    tolerance = robot.drive_gain_tolerance
    return {
        "gain": robot.drive_gain,
        "gain_tolerance": tolerance[0] if np.all(tolerance == tolerance[0]) else tolerance,
        "gear_ratio": robot.gear_ratio,
        **({"direct_drive": robot.direct_drive} if robot.direct_drive else {}),
        "coupling": robot.coupling,
    }


def _placement(placement: pin.SE3) -> dict[str, Any]:
    return {"origin": placement.translation, "rotation": placement.rotation}


def _links(robot: Robot) -> list[dict[str, Any]]:
    """A row a joint: how it hangs on its parent."""
    frames = zip(joints_of(robot.kinematics), link_frames(robot.kinematics), strict=True)
    return [_link(robot, i, joint, frame.child) for i, (joint, frame) in enumerate(frames)]


def _link(robot: Robot, place: int, joint: Joint, link: str) -> dict[str, Any]:
    return {
        "joint": robot.joints[place],
        "link": link,
        "parent": robot.joints[joint.parent] if joint.parent >= 0 else "",
        "kind": "revolute" if joint.revolute else "prismatic",
        "axis": joint.axis,
        **_placement(joint.placement),
    }


def _inertia(robot: Robot, place: int) -> dict[str, Any]:
    inertia = robot.kinematics.inertias[place + 1]
    return {
        "mass": inertia.mass,
        "center_of_mass": inertia.lever,
        "inertia": [inertia.inertia[i, j] for i, j in INERTIA_PLACES],
    }


def _effect_row(effect: Effect, model: Model, written: set[str]) -> dict[str, Any]:
    """The effect's fields, and its priors if all its parameters have one; adds those to `written`."""
    row: dict[str, Any] = {"name": name_of(effect)}
    row |= {key_of(f): value for f in fields(effect) if (value := getattr(effect, f.name)) is not None}
    names = [parameter.name for parameter in effect.parameters(model.robot)]
    if names and all(name in model.stated for name in names):
        row["values"] = [model.stated[name].value for name in names]
        row["std"] = [model.stated[name].std for name in names]
        written.update(names)
    return row
