"""Drive gains of a gap: those of the robot file, and those that the runs determine."""

from dataclasses import dataclass

import numpy as np

from ..fit.settled_gains import stated
from ..text_table import NORMAL_95
from .ladder import Ladder
from .trial import Trial


@dataclass(frozen=True, eq=False)
class DriveGains:
    """Joint torque per motor current of n joints.

    Attributes:
        stated: Gains of the robot file, with which the original file is simulated, shape (n,) [N m/A].
        identified: Gains of all other simulations, shape (n,) [N m/A]; None if the runs do not show them.
        half: Half of the 95 % interval of the identified gains, shape (n,) [N m/A].
    """

    stated: np.ndarray
    identified: np.ndarray | None = None
    half: np.ndarray | None = None


def drive_gains(ladder: Ladder, trial: Trial) -> DriveGains | None:
    """Gains of recorded currents; None if no currents were recorded, or if their gains are unknown.

    Args:
        ladder: Findings that are kept, and their fit.
        trial: The held-out runs, with the stated gains.
    """
    robot = trial.model.robot
    if robot.servo is not None or not stated(robot) or not any(run.current for run in trial.runs):
        return None
    gained = ladder.with_gains(trial)
    if gained is trial:
        return DriveGains(robot.drive_gain)
    gain, tolerance = gained.model.robot.drive_gain, gained.model.robot.drive_gain_tolerance
    return DriveGains(robot.drive_gain, gain, NORMAL_95 * tolerance * np.abs(gain))
