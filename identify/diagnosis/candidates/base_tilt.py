"""Base tilt: gravity has another direction than in the model."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..findings.quantities import length
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .parts.gravity import gravity_columns

LEANING = 0.02
"""How far a base that was set up level may lean [rad]: a degree."""


def tilts(model: Model) -> Iterator[Candidate]:
    """A base that leans: gravity has a part along its x and y axes."""

    def columns(run: Driven) -> np.ndarray:
        return gravity_columns(model, run, (0, 1))

    names, lower = ("tilt_x", "tilt_y"), (-np.inf, -np.inf)
    nominal = ((0.0, LEANING),) * 2
    yield Candidate(
        "base_tilt", (), columns, names, ("rad", "rad"), lower, smooth=True, expected=nominal, carried=True
    )


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """By what angle the base leans, where that was not found itself."""
    if "lean" in known or "tilt_x" not in known:
        return {}
    return {"lean": length(known, "tilt_x", "tilt_y")}


def _held(arm: Arm, finding: Finding) -> Arm:
    """An arm on which gravity acts otherwise."""
    robot = arm.model.robot
    kinematics = robot.kinematics.copy()
    field = np.array(kinematics.gravity.linear)
    known, size = {name: one.value for name, one in finding.parameters.items()}, float(np.linalg.norm(field))
    if "tilt_x" in known:
        turned = field + size * np.array([known["tilt_x"], known["tilt_y"], 0.0])
    else:
        turned = size * np.array([known[f"gravity_{axis}"] for axis in "xyz"])
    kinematics.gravity = pin.Motion(turned, np.zeros(3))
    return arm.on(replace(robot, kinematics=kinematics))


KIND = Kind(
    sentence="The base is not level: it leans by {lean:deg}[ (gravity has {tilt_x:deg} along x and "
    "{tilt_y:deg} along y)][ (gravity points along {gravity_x:bare}, {gravity_y:bare}, "
    "{gravity_z:bare} of the base frame)]",
    drawn_against=("position", "load"),
    ask=tilts,
    derived=_derived,
    held=_held,
    of_body=True,
    mistaken_for=("encoder_offset", "link_inertia"),
    settled_by="the base levelled, or turned by a right angle",
)
