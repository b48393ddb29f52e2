"""Drive gains that a known body contradicts: the study goes on with those that it gives.

What is stated of a gain is a claim. Where a run with a known body shows a gain that its tolerance excludes,
every other question would be asked in a wrong scale: the gain is named, and all else is asked beside it.
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
    """A drive gain that is not what is stated.

    Attributes:
        joint: From 0.
        gain: As the known body gives it [N m/A].
        std: Its relative standard deviation [-].
        share: By how much it is more than stated [-].
    """

    joint: int
    gain: float
    std: float
    share: float


def other_gains(fit: Fit | None, model: Model) -> list[OtherGain]:
    """Gains that runs with a known body determine, and that what is stated of them excludes."""
    robot = model.robot
    if fit is None or not stated(robot):
        return []
    gain, found = fit.estimate.gain, []
    std = fit.estimate.gain_std / np.abs(gain)
    for joint in np.flatnonzero(fit.estimate.gain_estimated):
        share, tolerance = gain[joint] / robot.drive_gain[joint] - 1.0, robot.drive_gain_tolerance[joint]
        # A sensor is linear to a few per cent: what is less is no other gain.
        excluded = STRANGE * np.hypot(max(tolerance, LINEAR), std[joint])
        if std[joint] <= max(tolerance, LINEAR) and abs(share) > excluded:
            found.append(OtherGain(int(joint), float(gain[joint]), float(std[joint]), float(share)))
    return found


def with_gains(model: Model, found: list[OtherGain]) -> Model:
    """The model with these, known to their deviation or to what sensors are linear by."""
    robot = model.robot
    gain, tolerance = np.array(robot.drive_gain), np.array(robot.drive_gain_tolerance)
    for one in found:
        gain[one.joint], tolerance[one.joint] = one.gain, max(one.std, LINEAR)
    return replace(model, robot=replace(robot, drive_gain=gain, drive_gain_tolerance=tolerance))


def gain_sentences(found: list[OtherGain], model: Model) -> list[str]:
    """What is said of each, before all that was asked beside it."""
    said = [
        f"{joint_words(one.joint, model.robot.joints)} has a drive that gives {100 * abs(one.share):.3g} ± "
        f"{100 * NORMAL_95 * one.std:.2g} % {'more' if one.share > 0.0 else 'less'} torque per current than "
        f"its nominal gain, stated to {100 * model.robot.drive_gain_tolerance[one.joint]:.2g} %, as the "
        "known body shows."
        for one in found
    ]
    return [*said, "What follows is asked with the gains that the body gives."] if said else []
