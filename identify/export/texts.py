"""Text formats that represent the complete model: JSON and robot.toml."""

from dataclasses import fields
from typing import Any

import numpy as np
import pinocchio as pin

from exidyn.quoting import json_text

from ..arm.newton_euler import joints_of, link_frames
from ..effects import Effect, name_of
from ..measurements import measurement_name
from ..model import Model
from ..robot_files.effect_rows import key_of
from ..robot_files.robot_text import model_text
from .portable import Portable

FORMAT = 1
"""Format version, increased when a reader of the previous version would misinterpret a file."""

NOT_IN_TOML = ("law", "delay", "feed_forward", "integral")
"""Features of servos that a robot file does not have."""


def json(portable: Portable) -> str:
    """A table of links, joints and effects in SI units; infinite or unknown values are null."""
    model, robot = portable.model, portable.robot
    table = {
        "exidyn_model": FORMAT,
        "robot": robot.name,
        "gravity": robot.gravity,
        "joints": [_joint(model, place) for place in range(robot.dof)],
        "coupling": robot.coupling,
        "flange": _placement(robot.flange),
        "effects": [_effect(model, effect) for effect in model.effects],
        "measurements": [
            {"name": measurement_name(measurement)}
            | {f.name: getattr(measurement, f.name) for f in fields(measurement)}
            for measurement in model.measurements
        ],
        "servos": None if portable.servos is None else vars(portable.servos),
    }
    return json_text(_plain(table)) + "\n"


def _joint(model: Model, place: int) -> dict[str, Any]:
    """Entry of a joint, its motor, and the link that it moves, in the link's frame."""
    robot = model.robot
    joint, body = joints_of(robot.kinematics)[place], robot.kinematics.inertias[place + 1]
    return {
        "name": robot.joints[place],
        "kind": "revolute" if joint.revolute else "prismatic",
        "parent": robot.joints[joint.parent] if joint.parent >= 0 else None,
        **_placement(joint.placement),
        "axis": joint.axis,
        "limits": {name: values[place] for name, values in vars(robot.limits).items()},
        "drive_gain": robot.drive_gain[place],
        "gear_ratio": robot.gear_ratio[place],
        "link": {
            "name": link_frames(robot.kinematics)[place].child,
            "mass": body.mass,
            "center_of_mass": body.lever,
            "inertia_about_center_of_mass": body.inertia,
        },
    }


def _placement(placement: pin.SE3) -> dict[str, Any]:
    return {"origin": placement.translation, "rotation": placement.rotation}


def _effect(model: Model, effect: Effect) -> dict[str, Any]:
    """Entry of an effect with its fields and parameters; the links have the parameters of bodies."""
    row: dict[str, Any] = {"name": name_of(effect)}
    row |= {key_of(f): getattr(effect, f.name) for f in fields(effect)}
    if effect.of_links:
        return row
    priors = dict(zip(model.names, model.priors, strict=True))
    row["parameters"] = [
        {"name": p.name, "unit": p.unit, "value": priors[p.name].value, "std": priors[p.name].std}
        for p in effect.parameters(model.robot)
    ]
    return row


def _plain(value: Any) -> Any:
    """The value in terms of lists, tables, text and finite numbers."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, str | None):
        return value
    number = float(value)
    return None if not np.isfinite(number) else int(number) if isinstance(value, int) else number


def toml(portable: Portable) -> str:
    """A robot file with the identified model, which every command accepts."""
    return model_text(portable.model)
