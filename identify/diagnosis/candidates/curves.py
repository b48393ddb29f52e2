"""Curves: torque of a joint over one quantity, where no formula of the vocabulary describes it."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ...effects import Effect, TorqueCurve
from ...effects.torque_curve import ABSCISSAE
from ...model import Model
from ..blocks.prediction import Prediction
from ..findings.family import DEPENDENCES
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from ..runs.usable import HELD_OUT
from .parts import RARE, of_effect


def curve(model: Model, over: str, joint: int, runs: Sequence[Driven]) -> TorqueCurve:
    """A curve of one joint over one quantity, within the range of that quantity in the fitted runs."""
    fitted = [run.motion for run in runs if run.role != HELD_OUT]
    values = np.concatenate([ABSCISSAE[over].values(motion)[:, joint] for motion in fitted])
    low = 0.0 if ABSCISSAE[over].size else float(values.min())
    return TorqueCurve((model.robot.joints[joint],), over=over, low=low, high=float(values.max()))


def _nothing(model: Model) -> Iterator[Candidate]:
    """No candidates, because the range of the runs is not known yet."""
    return iter(())


def _curves(over: str, model: Model, prediction: Prediction, runs: Sequence[Driven]) -> Iterator[Candidate]:
    """A curve on each joint that moves."""

    def unlisted(candidate: Candidate, effect: Effect) -> Candidate:
        return replace(candidate, listed=False, prior=RARE)

    for joint in range(model.robot.dof):
        effect, [name, _] = curve(model, over, joint, runs), CURVES[over]
        if effect.high > effect.low:
            yield of_effect(model, name, effect, KINDS[name], (joint,), unlisted)


CURVES = {
    "velocity": ("velocity_curve", ("speed", "velocity")),
    "direction": ("direction_curve", ("velocity", "position")),
    "load": ("load_curve", ("size of the load", "velocity")),
    "position": ("position_curve", ("position", "load")),
    "position and direction": ("braking_curve", ("where it brakes", "velocity")),
}
"""Abscissa of a curve -> its name, and the axes on which it is drawn."""

KINDS = {
    name: Kind(
        sentence=f"{{joint}} has {DEPENDENCES[over]}, in a way that no formula of the vocabulary describes",
        drawn_against=axes,
        ask=_nothing,
        ask_first=partial(_curves, over),
        family=over,
        formula=False,
    )
    for over, (name, axes) in CURVES.items()
} | {"torque_curve": Kind("{joint} has a curve of torque", ("position", "load"), "", False, _nothing)}
