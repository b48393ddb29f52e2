"""Servos of the file and friction of its joints, identified by simulation before the dynamics of the arm.

Measured torque states the law of a servo whatever the arm is, so a regression gives gains and limits there.
Everything else comes from simulations of the runs.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..diagnosis.runs.usable import HELD_OUT
from ..errors import ExidynError
from ..export.changes import Change
from ..fit.servo_fit import ServoRun, identify_servos
from ..model import Model
from ..preparation.prepare import Filtering
from ..recordings.recording import Recording
from ..recordings.servo_error import is_servo_error
from .distances import Gain, Judge
from .joint_numbers import DELAY, KP, LIMIT, JointNumbers, ServoChange, servo_changes
from .ladder import FARTHER
from .replay import POSITION
from .simulated_numbers import simulated_numbers
from .trial import Recordings, Source, Trial, simulated_runs


@dataclass(frozen=True, eq=False)
class ServoStage:
    """The file with the identified servos."""

    source: Source  # the file; the original one if its servos agree with the runs
    changes: tuple[ServoChange, ...]  # changed numbers of its servos
    text: bytes  # the file with identified friction, damping and armature of its joints too
    numbers: tuple[Change, ...]  # these changes
    delay: np.ndarray  # delay of the commands of each joint in the runs, shape (n,) [s]
    held: bool  # whether commands are held from sample to sample in a simulation of the runs
    undetermined: tuple[int, ...] = ()  # joints whose stiffness the runs leave open
    # Whether the simulation of the held-out runs is nearer to them; None if nothing differs.
    gain: Gain | None = None
    reason: str = ""  # why the changes are not written; empty if they are


def unchanged(source: Source, model: Model) -> ServoStage:
    """The stage of a file whose servos are not identified."""
    return ServoStage(source, (), source.text, (), np.zeros(model.robot.dof), False)


def servo_stage(
    source: Source, model: Model, recordings: Recordings, raw: Recordings, filtering: Filtering, judge: Judge
) -> ServoStage:
    """Identify the servos from the runs that are not held out, and write what differs into the file.

    Those in `raw` have a torque. The judge decides on the held-out runs
    whether the changes are written.
    """
    used = [run for role, run in recordings if role != HELD_OUT and "command" in run.signals]
    numbers = JointNumbers(source, model.robot)
    if not np.all(numbers.law.stiffness) or not used:
        return unchanged(source, model)
    training, judging = (
        Trial(source, model, simulated_runs(raw, filtering, held_out), POSITION) for held_out in (False, True)
    )
    try:
        stage = _identified(numbers, used, training, judging)
    except ExidynError as error:
        return replace(unchanged(source, model), gain=Gain.SAME, reason=" ".join(str(error).split()))
    if not stage.changes:
        return stage
    trial = replace(judging, held=stage.held)
    gain = judge.compared(trial.distances(source.text), trial.distances(stage.text))
    if gain is Gain.WORSE:
        return replace(unchanged(source, model), held=stage.held, gain=gain, reason=FARTHER)
    return replace(stage, gain=gain)


def _identified(
    numbers: JointNumbers, used: Sequence[Recording], training: Trial, judging: Trial
) -> ServoStage:
    """Stage with all numbers that the used runs and simulations give.

    Gains and limits come from measured torque, if there is any, and delays, friction and armature from
    simulations.
    """
    by_torque = not any(is_servo_error(run.settings) for run in used)
    known, changes = numbers, tuple[ServoChange, ...]()
    if by_torque:
        robot = numbers.robot
        fit = identify_servos([ServoRun.of(run, robot.drive_gain) for run in used])
        changes = servo_changes(fit, numbers.law)
        known = JointNumbers(numbers.with_servos(changes), robot, fixed=True)
    training, judging = (replace(trial, source=known.source) for trial in (training, judging))
    rows = (KP, LIMIT) if by_torque else ()
    result = simulated_numbers(known, training, judging, known.source.text, rows)
    simulated = known.servo_changes(result.values, result.halves)
    changes += tuple(change for change in simulated if not by_torque or change.quantity == "delay")
    written = numbers.with_servos(changes)
    text, joints = known.with_joints(written.text, result.values, result.halves)
    undetermined = tuple(np.flatnonzero(result.undetermined).tolist())
    return ServoStage(written, changes, text, joints, result.values[DELAY], result.held, undetermined)
