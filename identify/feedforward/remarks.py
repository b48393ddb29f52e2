"""Remarks on a feedforward: what the fit contains and a file does not, and what it assumes."""

from collections.abc import Iterator

import numpy as np

from ..dynamics.dynamics import Dynamics
from ..export.left_out import effect_sentences
from ..fit.fit import Fit
from ..measurements import measurement_name


def remarks(fit: Fit, dynamics: Dynamics) -> Iterator[str]:
    """One sentence for each effect that is missing and each assumption."""
    robot = fit.model.robot
    for sentence in effect_sentences(fit.model, dynamics.left_out):
        yield f"not included: {sentence}"
    for measurement in fit.model.measurements:
        yield (
            f"not included: {measurement_name(measurement)}; the torque is that of rigid gears, without delay"
        )
    if fit.unscaled:
        yield "drive gains are unknown: what is called torque is motor current times the nominal gain of 1"
    elif fit.measures == "current" and not np.any(fit.estimate.gain_estimated):
        yield (
            "drive gains are nominal, not estimated: torques are as uncertain as these; "
            "exidyn identify --payload RUN --mass KG estimates them"
        )
    if dynamics.needs_temperature:
        yield "friction depends on temperature: give the temperature of each joint [degC]"
    if robot.passive:
        yield f"joints without a motor: {', '.join(robot.passive)}; their torque cannot be applied"
