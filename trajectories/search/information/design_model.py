"""The model as an optimiser sees it: friction reverses over as wide a velocity as a sample covers."""

from dataclasses import replace

import numpy as np

from exidyn.identify.arm.robot import Limits
from exidyn.identify.model import Model

WIDEST = 0.1
"""Velocity over which friction reverses in a design at most [rad/s]: beyond, viscous friction is like it."""


def design_model(model: Model, limits: Limits, spacing: float) -> Model:
    """The model with every reversal as wide as what a velocity changes between two samples.

    Friction that reverses within milliradians a second is a step between two samples, whose gradient is zero
    everywhere else. A row of the equations is a mean over its time, in which it reverses as gradually as
    here.

    Args:
        model: Nominal.
        limits: Finite accelerations.
        spacing: Time between samples [s].
    """
    change = 0.5 * float(np.median(limits.acceleration)) * spacing  # half of it: a sinusoid's mean
    effects = []
    for effect in model.effects:
        shapes = effect.shapes()
        if "reversal" in shapes:
            stated = float(getattr(effect, "reversal"))  # noqa: B009
            width = max(stated, min(change, WIDEST, shapes["reversal"].high))
            effect = replace(effect, reversal=width)  # type: ignore[call-arg]
        effects.append(effect)
    return replace(model, effects=tuple(effects))
