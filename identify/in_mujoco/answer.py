"""The two answers of a gap: the best file by itself, and the file with effects attached."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..errors import ExidynError
from ..export.changes import Change
from ..export.portable import Portable
from ..fit.fit import Fit
from ..fit.settled_gains import stated
from ..model import Model
from ..robot_files.mjcf_elements import JOINT_TERMS
from ..text_table import NORMAL_95
from .distances import Distances, Gain, Judge
from .joint_numbers import DELAY, KP, LIMIT, TERMS, JointNumbers
from .ladder import Ladder
from .servo_stage import ServoStage
from .simulated_numbers import simulated_numbers
from .trial import Trial


@dataclass(frozen=True, eq=False)
class Answer:
    """A version of the user's file."""

    text: bytes  # its text; the original one if nothing in it is better
    distances: Distances  # distances of its simulation from the held-out runs
    changes: tuple[Change, ...]  # changed numbers, in addition to those of the servos
    arm: Model  # the arm whose effects are attached; for the file by itself, the arm that it describes
    # The fit from which the arm comes; None if its numbers come from the file or from simulation.
    fit: Fit | None = None
    left_out: tuple[str, ...] = ()  # what the file cannot hold, in words

    @property
    def attaches(self) -> bool:
        """Whether effects have to be attached for its distances."""
        return self.fit is not None


def attached(ladder: Ladder, file: Answer) -> Answer:
    """The file with the findings; the file by itself if the simulation is no nearer for what is attached.

    Findings have their evidence in the torque, so they stay unless they move the simulation away. Without
    findings, effects that the robot file states are attached if they gain; another law of dry friction alone
    is no reason.
    """
    gain, step = ladder.judge.compared(file.distances, ladder.last), ladder.best
    if step is None or gain is Gain.WORSE:
        return file
    if not ladder.findings and (gain is Gain.SAME or not Portable.of(step.arm).others):
        return file
    return Answer(step.text, ladder.last, step.changes, step.arm, step.fit, step.left_out)


def file_alone(ladder: Ladder, training: Trial, servos: ServoStage | None = None) -> Answer:
    """The version of the file that is nearest to the held-out runs by itself, with identified drive gains.

    The first version has the numbers that simulations of the training runs gave. Fits without and with the
    findings give further versions, which also differ in bodies; the best of them is refined too. A version
    has to be nearer than the best before it, so that few changes come first.
    """
    trial, training = ladder.with_gains(ladder.trial), ladder.with_gains(training)
    original = Answer(trial.source.text, ladder.start, (), ladder.trial.model)
    if servos is not None:
        first = _by_joint(trial, ladder.judge, original, servos.text, servos.numbers)
    else:
        first = _refined(trial, training, ladder.judge, original)
    fitted = first
    for text, changes in _fitted(ladder):
        distances = trial.distances(text)
        if ladder.judge.compared(fitted.distances, distances) is Gain.BETTER:
            fitted = Answer(text, distances, changes, trial.model)
    return first if fitted is first else _refined(trial, training, ladder.judge, fitted)


def _refined(trial: Trial, training: Trial, judge: Judge, answer: Answer) -> Answer:
    """The answer with joint numbers by simulation of the training runs."""
    numbers = JointNumbers(trial.source, trial.model.robot, trial.commands, fixed=True)
    found = simulated_numbers(numbers, training, trial, answer.text, (KP, LIMIT, DELAY))
    text, changes = numbers.with_joints(answer.text, found.values, found.halves)
    others = [change for change in answer.changes if change.attribute not in REFINED]
    return _by_joint(trial, judge, answer, text, (*others, *changes))


def _by_joint(trial: Trial, judge: Judge, best: Answer, text: bytes, changes: tuple[Change, ...]) -> Answer:
    """The version, in which single joints follow the held-out runs better, unless the whole arm does not."""
    distances = trial.distances(text)
    if not changes or judge.compared(best.distances, distances) is Gain.WORSE:
        return best
    return Answer(text, distances, changes, trial.model)


REFINED = [JOINT_TERMS[term].attribute for term in TERMS]
"""Attributes that are refined."""


def _fitted(ladder: Ladder) -> Iterator[tuple[bytes, tuple[Change, ...]]]:
    """Texts with the numbers of fits without and with the findings, and their changes."""
    try:
        step = ladder.step(())
        yield step.text, step.changes
    except ExidynError:  # it has a stage with the reason
        pass
    if ladder.best is not None:
        yield ladder.best.text, ladder.best.changes


@dataclass(frozen=True, eq=False)
class DriveGains:
    """Joint torque per motor current of n joints."""

    # Gains of the robot file, with which the original file is simulated, shape (n,) [N m/A].
    stated: np.ndarray
    # Gains of all other simulations, shape (n,) [N m/A]; None if the runs do not show them.
    identified: np.ndarray | None = None
    half: np.ndarray | None = None  # half of the 95 % interval of the identified gains, shape (n,) [N m/A]


def drive_gains(ladder: Ladder, trial: Trial) -> DriveGains | None:
    """Gains of currents; None if none were recorded, or if the gains stated in the trial are unknown."""
    robot = trial.model.robot
    if not stated(robot) or not any(run.current for run in trial.runs):
        return None
    gained = ladder.with_gains(trial)
    if gained is trial:
        return DriveGains(robot.drive_gain)
    gain, tolerance = gained.model.robot.drive_gain, gained.model.robot.drive_gain_tolerance
    return DriveGains(robot.drive_gain, gain, NORMAL_95 * tolerance * np.abs(gain))
