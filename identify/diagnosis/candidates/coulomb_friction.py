"""Coulomb friction other than in the model, or of a joint for which the model has none."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...model import Model
from ..findings.kind import Kind
from ..questions.candidate import UNNAMED, Candidate
from ..runs.driven import Driven
from ..runs.nuisances import PRESLIDING, REVERSAL_STD, REVERSALS, dry, turning
from .parts.motors import on_motors
from .parts.of_effect import on_each_joint


def dry_frictions(model: Model) -> Iterator[Candidate]:
    """Dry friction of each joint; where the model has none, it turns its sign in some way or other."""
    believed = dry(model, model.believed_values)
    for joint, candidate in enumerate(on_each_joint(model, "coulomb_friction", KIND)):
        yield candidate if joint in believed else _turning(model, joint, candidate)


def _turning(model: Model, joint: int, candidate: Candidate) -> Candidate:
    def columns(run: Driven) -> np.ndarray:
        turns = on_motors(model.robot, turning(model, run, joint))
        return np.concatenate([candidate.columns(run), turns], axis=2)

    count = len(REVERSALS) - 1 + len(PRESLIDING)
    return replace(
        candidate,
        columns=columns,
        names=(*candidate.names, *(f"{UNNAMED}{k + 1}" for k in range(count))),
        units=(*candidate.units, *("N m",) * count),
        lower=(*candidate.lower, *(-np.inf,) * count),
        proportion=(1.0, *(REVERSAL_STD,) * count),
        led=1,
    )


KIND = Kind(
    sentence="{joint} has a Coulomb friction {Fc:size} {Fc:higher|lower} than in the model",
    drawn_against=("velocity", "speed"),
    ask=dry_frictions,
    reducible=True,
    mistaken_for=("stribeck_friction", "load_dependent_friction"),
)
