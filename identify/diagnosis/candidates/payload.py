"""Payload: a body on the flange in every run, of which the model does not know."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...effects import Payload
from ...model import Model
from ..findings.arm import Arm
from ..findings.arm_bodies import found_body, heavier
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .parts.bodies import PARTS, PROPORTION, UNITS, centre
from .parts.motors import on_motors


def payloads(model: Model) -> Iterator[Candidate]:
    """A body of which only its mass has a sign."""
    body, robot = Payload("unknown"), model.robot
    names = [parameter.name for parameter in body.parameters(robot)]
    kept = [names.index(f"{part}unknown") for part in PARTS]

    def columns(run: Driven) -> np.ndarray:
        return on_motors(robot, body.regressor(robot, replace(run.motion, payload="unknown"))[:, :, kept])

    lower = (0.0, *(-np.inf,) * 9)
    yield Candidate(
        "payload",
        (),
        columns,
        PARTS,
        UNITS,
        lower,
        smooth=True,
        proportion=PROPORTION,
        led=1,
        cancels=True,
        carried=True,
    )


def _held(arm: Arm, finding: Finding) -> Arm | None:
    """The last link with the body on it."""
    placement = arm.model.robot.flange.homogeneous
    return heavier(arm, arm.model.robot.dof - 1, placement @ found_body(finding) @ placement.T)


KIND = Kind(
    sentence="The flange carries a payload that the model does not have: {M}[, its centre of mass at "
    "{centre} mm in the flange's frame][, but these runs hardly determine its mass; its first "
    "moments are {moments} kg m in the flange's frame]",
    drawn_against=("position", "acceleration"),
    ask=payloads,
    derived=centre,
    held=_held,
    of_body=True,
    mistaken_for=("link_inertia", "drive_gain"),
    settled_by="a run with a body of known mass on the flange",
)
