"""The two answers of a gap: the best file by itself, and the file with effects attached."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..arm.motion import Motion
from ..errors import ExidynError
from ..export.mjcf_changes import TERMS, Change
from ..export.portable import Portable
from ..export.spread import Spread
from ..fit.fit import Fit
from ..fit.identified import standard_parameters
from ..fit.settled_gains import stated
from ..model import Model
from ..robot_files.mjcf import compile_mjcf
from ..text_table import NORMAL_95
from .distances import Distances
from .judge import Gain, Judge
from .ladder import Ladder
from .refine import FIELDS, Refinement, joint_numbers
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


def file_alone(ladder: Ladder, training: Trial) -> Answer:
    """The version of the file that is nearest to the held-out runs by itself, with identified drive gains.

    The first version has the friction of a fit without findings, refined in simulations of the training runs.
    Fits without and with the findings give further versions, which also differ in bodies; the best of them is
    refined too. A version has to be nearer than the best before it, so that few changes come first.
    """
    trial, training = ladder.with_gains(ladder.trial), ladder.with_gains(training)
    original = Answer(trial.source.text, ladder.start, (), ladder.trial.model)
    first = _refined(trial, training, ladder.judge, original, *friction(ladder))
    fitted = first
    for text, changes in _fitted(ladder):
        fitted = _nearer(trial, ladder.judge, fitted, text, changes)
    if fitted is first:
        return first
    numbers = _numbers(trial, fitted.text)
    return _refined(trial, training, ladder.judge, fitted, numbers, np.full(numbers.shape, np.inf))


def _refined(
    trial: Trial, training: Trial, judge: Judge, answer: Answer, start: np.ndarray, std: np.ndarray
) -> Answer:
    """The answer with refined joint numbers if it is nearer, else as it is."""
    text, changes = Refinement(training, answer.text, start, std, scale_of(training)).refined()
    others = [change for change in answer.changes if change.attribute not in REFINED]
    return _nearer(trial, judge, answer, text, (*others, *changes))


def friction(ladder: Ladder) -> tuple[np.ndarray, np.ndarray]:
    """Joint numbers of the file with damping and dry friction of a fit, and standard deviations, (3, n) each.

    The deviations are infinite for what only the file states.
    """
    trial = ladder.trial
    numbers = _numbers(trial, trial.source.text)
    std = np.full(numbers.shape, np.inf)
    try:
        step = ladder.step(())
    except ExidynError:  # it has a stage with the reason
        return numbers, std
    numbers[1:] = _numbers(trial, step.text)[1:]
    spread = Spread(step.fit.model, standard_parameters(step.fit))
    for row, term in enumerate(FIELDS):
        halves = [spread.half(place, term) for place in range(numbers.shape[1])]
        if row:
            std[row] = np.hypot(np.array(halves) / NORMAL_95, LAW * numbers[row])
    return numbers, std


def with_drive_gains(ladder: Ladder) -> bytes:
    """The file with the numbers of a fit if its servos have drive gains, which are fitted; else as it is."""
    source = ladder.trial.source
    if ladder.trial.model.robot.servo is None:
        return source.text
    try:
        return ladder.step(()).text
    except ExidynError:  # it has a stage with the reason
        return source.text


def _numbers(trial: Trial, text: bytes) -> np.ndarray:
    compiled = compile_mjcf(text.decode(), trial.source.folder)
    return joint_numbers(compiled, trial.model.robot.joints)


LAW = 0.2
"""Relative difference of friction between a fit and MuJoCo, whose dry friction creeps on light joints."""
REFINED = [TERMS[term][0] for term in FIELDS]
"""Attributes that are refined."""


def _nearer(trial: Trial, judge: Judge, best: Answer, text: bytes, changes: tuple[Change, ...]) -> Answer:
    """The version if it is nearer than the best one, else the best one."""
    distances = trial.distances(text)
    if judge.compared(best.distances, distances) is not Gain.BETTER:
        return best
    return Answer(text, distances, changes, trial.model)


def _fitted(ladder: Ladder) -> Iterator[tuple[bytes, tuple[Change, ...]]]:
    """Texts with the numbers of fits without and with the findings, and their changes."""
    try:
        step = ladder.step(())
        yield step.text, step.changes
    except ExidynError:  # it has a stage with the reason
        pass
    if ladder.best is not None:
        yield ladder.best.text, ladder.best.changes


def scale_of(training: Trial) -> np.ndarray:
    """Size of armature, damping and dry friction that shows in the motion of each joint, shape (3, n).

    It is a tenth of the torque that moves the joint, at its rms acceleration and velocity.
    """
    model, joints = training.model, Portable.of(training.model).joints
    motions = [
        Motion.of(run.time, run.position, run.velocity, np.gradient(run.velocity, run.time, axis=0))
        for run in training.runs
    ]
    velocity, acceleration, torque = (
        np.sqrt(np.mean(np.concatenate(parts) ** 2, axis=0)) + np.finfo(float).tiny
        for parts in (
            [motion.velocity for motion in motions],
            [motion.acceleration for motion in motions],
            [model.torque(motion, model.nominal_values) for motion in motions],
        )
    )
    typical = 0.1 * torque * np.array([1.0 / acceleration, 1.0 / velocity, np.ones(len(torque))])
    return np.maximum(typical, 0.1 * np.array([getattr(joints, term) for term in FIELDS]))


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
