"""How dry friction changes its sign, on a joint for which the model has none."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ....model import Model
from ...questions.candidate import UNNAMED, Candidate
from ...runs.driven import Driven
from ...runs.rows import PRESLIDING, REVERSAL_STD, REVERSALS, dry, turning
from .motors import on_motors

COUNT = len(REVERSALS) - 1 + len(PRESLIDING)


def with_turning(model: Model, joint: int, candidate: Candidate) -> Candidate:
    """The candidate with other ways of turning its sign beside it, unless the model's friction has them."""
    return candidate if joint in dry(model, model.nominal_values) else _with_turning(model, joint, candidate)


def _with_turning(model: Model, joint: int, candidate: Candidate) -> Candidate:
    def columns(run: Driven) -> np.ndarray:
        turns = on_motors(model.robot, turning(model, run, joint))
        return np.concatenate([candidate.columns(run), turns], axis=2)

    def reshaped(given: Mapping[str, float]) -> Candidate:
        assert candidate.reshaped is not None
        return _with_turning(model, joint, candidate.reshaped(given))

    return replace(
        candidate,
        columns=columns,
        names=(*candidate.names, *(f"{UNNAMED}{k + 1}" for k in range(COUNT))),
        units=(*candidate.units, *("N m",) * COUNT),
        lower=(*candidate.lower, *(-np.inf,) * COUNT),
        proportion=(1.0, *(REVERSAL_STD,) * COUNT),
        led=1,
        reshaped=reshaped,
    )
