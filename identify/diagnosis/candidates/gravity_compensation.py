"""Gravity compensation: motors carry another share of the arm's weight than in the model.

Springs and counterweights of cheap arms do so on purpose, and MuJoCo's `gravcomp` is such a share. In a log,
a controller may have subtracted it from the efforts.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Hypothesis
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .base_tilt import gravity_columns, under_gravity
from .parts import RARE

EXPECTED = ((0.0, 1.0),)
"""Prior mean and standard deviation of the share [-]: about any share up to all of the weight."""


EARTH = np.array([0.0, 0.0, -9.81])
"""Gravity where the model has none [m/s^2]."""
COMPENSATED, LOADING = "compensated", "loading"
"""Share of the weight that motors carry less than in the model; or that they carry, if it has no gravity."""


def compensations(model: Model) -> Iterator[Candidate]:
    """Less weight than in the model; of a model without gravity, weight that loads its motors."""
    weightless = not np.any(model.robot.gravity)
    field, sign = (EARTH, 1.0) if weightless else (model.robot.gravity, -1.0)

    def columns(run: Driven) -> np.ndarray:
        return sign * gravity_columns(model, run, field[None])

    names, lower = ((LOADING,), (0.0,)) if weightless else ((COMPENSATED,), (-np.inf,))
    yield Candidate(
        "gravity_compensation", (), columns, names, ("1",), lower, smooth=True, expected=EXPECTED,
        carried=True, loaded=True, prior=RARE, listed=False,
    )  # fmt: skip


def _held(arm: Arm, finding: Hypothesis) -> Arm:
    """The arm with as much less gravity, or as much gravity, which moves its links alike."""
    shares = finding.numbers
    if LOADING in shares:
        return replace(arm, model=under_gravity(arm.model, shares[LOADING] * EARTH))
    remaining = max(1.0 - shares[COMPENSATED], 0.0)
    return replace(arm, model=under_gravity(arm.model, remaining * arm.model.robot.gravity))


KINDS = {
    "gravity_compensation": Kind(
        family="gravity",
        sentence="[Motors carry {loading:%} of the arm's weight, and none in the model][Motors carry "
        "{compensated:size %} {compensated:less|more} of the arm's weight than in the model, as with "
        "springs, counterweights or gravcomp, or with a controller that subtracts it from the efforts]",
        drawn_against=("position", "load"),
        ask=compensations,
        held=_held,
        of_body=True,
        settled_by="the links weighed, or one joint held by hand with its motor off",
    )
}
