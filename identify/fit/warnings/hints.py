"""What a run leaves open, and which motion would settle it."""

import numpy as np

from ...arm.motion import Motion
from ...model import Model
from ..base_parameters import BaseParameters, rich_motion
from ..estimators import Estimate
from ..fit import Unclear
from ..settled_gains import cure, open_by_gain

OPEN = 30.0
"""Per cent of its value at which a parameter counts as open: two deviations are then most of it, and
Gautier's rule of thumb drops parameters from about there."""


def unclear(model: Model, base: BaseParameters, estimate: Estimate, payload: str = "") -> tuple[Unclear, ...]:
    """Parameters above `OPEN` per cent, each with the motion most informative about it."""
    percent = 100.0 * estimate.std / np.maximum(np.abs(estimate.values), np.finfo(float).tiny)
    found = np.flatnonzero(percent > OPEN)
    if len(found) == 0:
        return ()
    motion = rich_motion(model, payload=payload, seed=7)
    regressor = model.regressor(motion)[:, :, base.kept] / estimate.noise[None, :, None]
    count = len(estimate.values)
    covariance = estimate.covariance[:count, :count]
    # One more sample with row w shrinks the variance by (w c)^2 / (1 + w C w), c the column of C.
    seen = regressor @ covariance
    spread = np.sum(seen * regressor, axis=2)
    hints = []
    by_gain = open_by_gain(estimate, model.robot)
    for column in found:
        percents = float(percent[column])
        if column in by_gain:  # no motion shows what only a known torque does
            hints.append(Unclear(base.names[column], percents, cure(model.robot, by_gain[int(column)])))
            continue
        gain = np.max(seen[:, :, column] ** 2 / (1.0 + spread), axis=1)
        hints.append(Unclear(base.names[column], percents, _in_words(model, motion, gain)))
    return tuple(hints)


def _in_words(model: Model, motion: Motion, gain: np.ndarray) -> str:
    """What the most informative tenth of random samples has in common."""
    best = gain >= np.quantile(gain, 0.9)
    middle = np.mean(motion.position, axis=0)
    kinds = {
        "accelerate {} hard": np.abs(motion.acceleration),
        "move {} fast": np.abs(motion.velocity),
        "take {} far from the middle of its range": np.abs(motion.position - middle),
    }
    shifts = {}
    for phrase, values in kinds.items():
        excess = (values[best].mean(axis=0) - values.mean(axis=0)) / values.std(axis=0)
        for joint, amount in zip(model.robot.joints, excess, strict=True):
            shifts[phrase.format(joint)] = float(amount)
    first, second = sorted(shifts, key=lambda phrase: -shifts[phrase])[:2]
    # A mean of forty of four hundred scatters by 0.16; half as much as the first is still significant.
    return f"{first} and {second}" if shifts[second] > max(0.5 * shifts[first], 0.5) else first
