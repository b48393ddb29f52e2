"""Drive gains that a known payload contradicts: the study continues with the gains that the payload gives.

A nominal gain is a claim. If a run with a known payload shows a gain outside its tolerance, every other
question would be asked on a wrong scale. So the gain is reported, and the other questions use the new value.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from exidyn.identification.diagnosis.blocks.prediction import LINEAR
from exidyn.identification.diagnosis.questions.block_answer import STRANGE
from exidyn.identification.diagnosis.words.naming import joint_words
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.settled_gains import stated
from exidyn.identification.model import Model
from exidyn.identification.text_table import NORMAL_95


class OtherGain(NamedTuple):
    """A drive gain that differs from its nominal value.

    Attributes:
        joint: Index of the joint, from 0.
        gain: Gain determined with the known payload [N m/A].
        std: Relative standard deviation of the gain [-].
        share: Relative difference from the nominal gain [-].
    """

    joint: int
    gain: float
    std: float
    share: float


def other_gains(fit: Fit | None, model: Model) -> list[OtherGain]:
    """Gains determined by runs with a known payload that lie outside their nominal tolerance."""
    robot = model.robot
    if fit is None or not stated(robot):
        return []
    gain, others = fit.estimate.gain, []
    std = fit.estimate.gain_std / np.abs(gain)
    for joint in np.flatnonzero(fit.estimate.gain_estimated):
        share, tolerance = gain[joint] / robot.drive_gain[joint] - 1.0, robot.drive_gain_tolerance[joint]
        # Sensors are linear to a few percent: a smaller difference is not evidence of another gain.
        excluded = STRANGE * np.hypot(max(tolerance, LINEAR), std[joint])
        if std[joint] <= max(tolerance, LINEAR) and abs(share) > excluded:
            others.append(OtherGain(int(joint), float(gain[joint]), float(std[joint]), float(share)))
    return others


def with_gains(model: Model, gains: list[OtherGain]) -> Model:
    """The model with these gains, each with its std or the linearity of sensors as tolerance."""
    robot = model.robot
    gain, tolerance = np.array(robot.drive_gain), np.array(robot.drive_gain_tolerance)
    for other in gains:
        gain[other.joint], tolerance[other.joint] = other.gain, max(other.std, LINEAR)
    return replace(model, robot=replace(robot, drive_gain=gain, drive_gain_tolerance=tolerance))


def gain_sentences(gains: list[OtherGain], model: Model) -> list[str]:
    """One sentence per gain, and a sentence about what follows; empty without gains."""
    sentences = [
        f"{joint_words(other.joint, model.robot.joints)} has a drive that gives "
        f"{100 * abs(other.share):.3g} ± {100 * NORMAL_95 * other.std:.2g} % "
        f"{'more' if other.share > 0.0 else 'less'} torque per current than its nominal gain "
        f"(tolerance {100 * model.robot.drive_gain_tolerance[other.joint]:.2g} %), as the known payload "
        "shows."
        for other in gains
    ]
    return [*sentences, "All other conclusions use the gains that the payload gives."] if sentences else []
