"""Gravity compensation: something carries a share of the arm's weight that motors carry in the model.

Springs and counterweights of cheap arms do so on purpose, and MuJoCo's `gravcomp` is such a share. In a log,
a controller may have subtracted it from the efforts.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Hypothesis
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .base_tilt import under_gravity
from .parts import RARE, on_motors

EXPECTED = ((0.0, 1.0),)
"""Prior mean and standard deviation of the share [-]: any share up to all of the weight."""


def compensations(model: Model) -> Iterator[Candidate]:
    """The weight of all links that motors do not carry, if there is gravity."""
    if not np.any(model.robot.gravity):
        return

    def columns(run: Driven) -> np.ndarray:
        bodies = run.bodies.copy()
        bodies.gravity = pin.Motion(model.robot.gravity, np.zeros(3))
        data = bodies.createData()
        weight = [pin.computeGeneralizedGravity(bodies, data, q).copy() for q in run.motion.position]
        return on_motors(model.robot, -np.array(weight)[:, :, None])

    yield Candidate(
        "gravity_compensation", (), columns, ("share",), ("1",), (0.0,), smooth=True, expected=EXPECTED,
        carried=True, prior=RARE, listed=False,
    )  # fmt: skip


def _held(arm: Arm, finding: Hypothesis) -> Arm:
    """The arm with as much less gravity, which moves its links alike."""
    left = max(1.0 - finding.parameters["share"].value, 0.0)
    return replace(arm, model=under_gravity(arm.model, left * arm.model.robot.gravity))


KINDS = {
    "gravity_compensation": Kind(
        family="gravity",
        sentence="Something carries {share:%} of the arm's weight, such as springs, counterweights or "
        "gravcomp, or the controller has subtracted it from the efforts",
        drawn_against=("position", "load"),
        ask=compensations,
        held=_held,
        of_body=True,
        mistaken_for=("base_tilt", "link_inertia", "spring_balancer"),
        settled_by="the links weighed, or one joint held by hand with its motor off",
    )
}
"""Name -> kind."""
