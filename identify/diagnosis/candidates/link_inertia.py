"""Link inertia: a link that is heavier, lighter or elsewhere than its tolerance allows."""

from collections.abc import Iterator
from functools import cache

import numpy as np
import pinocchio as pin

from ...effects import RigidBody
from ...effects.rigid_body import inertial_priors
from ...model import Model
from ..findings.arm import Arm
from ..findings.arm_bodies import found_body, heavier
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .parts.bodies import PARTS, PROPORTION, UNITS, centre
from .parts.motors import on_motors

LIGHTEST = 1e-3
"""Mass by which any link may be off [kg]."""


def links(model: Model) -> Iterator[Candidate]:
    """Each link in turn, if bodies are part of the model."""
    if not any(isinstance(effect, RigidBody) for effect in model.effects):
        return
    robot, body = model.robot, RigidBody()
    own = [parameter.name for parameter in body.parameters(robot)]
    nominal = dict(zip(model.names, model.nominal_values, strict=True))

    @cache
    def regressor(run: Driven) -> np.ndarray:
        return body.regressor(robot, run.motion)

    for link in range(robot.dof):
        kept = [own.index(f"{part}{link + 1}") for part in PARTS]

        def columns(run: Driven, kept: list[int] = kept) -> np.ndarray:
            return on_motors(robot, regressor(run)[:, :, kept])

        # A link may be lighter, but by no more than it weighs.
        weight = max(float(nominal[f"M{link + 1}"]), 0.0)
        names, lower = tuple(f"{part}{link + 1}" for part in PARTS), (-weight, *(-np.inf,) * 9)
        yield Candidate(
            "link_inertia", (link,), columns, names, UNITS, lower, smooth=True, proportion=PROPORTION, led=1,
            expected=_as_heavy(robot.kinematics.inertias[link + 1]), carried=True,
        )  # fmt: skip


def _as_heavy(body: pin.Inertia) -> tuple[tuple[float, float], ...]:
    """How far a link's parameters may be off: about as much as it has, and never less than a gram's worth."""
    nominal = inertial_priors(body, 1.0)
    least = LIGHTEST * np.array(PROPORTION)
    return tuple((0.0, max(nominal[part].std, float(own))) for part, own in zip(PARTS, least, strict=True))


def _held(arm: Arm, finding: Finding) -> Arm | None:
    """A link with other mass and moments."""
    [link] = finding.joints
    return heavier(arm, link, found_body(finding, str(link + 1)))


KIND = Kind(
    sentence="Link {number} is not the body that the model has: {M:size} {M:heavier|lighter}[, first "
    "moments off by {shift} kg m]",
    drawn_against=("position", "acceleration"),
    ask=links,
    derived=centre,
    held=_held,
    of_body=True,
    mistaken_for=("payload", "spring_balancer", "drive_gain"),
    settled_by="a run with a body of known mass on the flange",
)
