"""Servos of the file, identified before the dynamics of the arm: gains, limits and delays of commands."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arm.servo_law import ServoLaw
from ..diagnosis.runs.usable import HELD_OUT
from ..errors import ExidynError
from ..export.mjcf_controller import with_servo_law
from ..fit.servo_fit import BLOCKS, ServoFit, identify_servos, identify_unscaled
from ..fit.servo_runs import ServoRun
from ..model import Model
from ..preparation.prepare import Filtering
from ..recordings.recording import Recording
from ..recordings.servo_error import is_servo_error
from ..robot_files.mjcf import compile_mjcf
from ..robot_files.mjcf_drives import servo_law
from .judge import Gain, Judge
from .ladder import FARTHER
from .refine import Refinement
from .replay import POSITION, Run
from .servo_changes import DELAY, KP, KV, QUANTITIES, ServoChange, changed_law, delay_changes, servo_changes
from .simulated_gains import with_simulated_delay, with_simulated_gains
from .simulated_limits import with_simulated_limits
from .trial import Source, Trial, simulated_runs

HALVED = 0.5
"""Ratio of residual variances below which the file's rotor inertia is wrong: the law of friction leaves
differences of a tenth."""
SLOW = 0.005
"""Sampling period above which it matters whether commands are held or interpolated [s]: half of it is longer
than a step of a simulation."""
LEAST = 0.1
"""Delay in sampling periods that is left of one, if commands are held, from which on it is written."""


@dataclass(frozen=True, eq=False)
class ServoStage:
    """The file with the identified servos."""

    source: Source  # the file; the original one if its servos agree with the runs
    changes: tuple[ServoChange, ...]  # changed numbers of its servos
    delay: np.ndarray  # delay of the commands of each joint in the runs, shape (n,) [s]
    held: bool  # whether commands are held from sample to sample in a simulation of the runs
    # Whether the simulation of the held-out runs is nearer to them; None if nothing differs.
    gain: Gain | None = None
    reason: str = ""  # why the changes are not written; empty if they are


def unchanged(source: Source, model: Model) -> ServoStage:
    """The stage of a file whose servos are not identified."""
    return ServoStage(source, (), np.zeros(model.robot.dof), False)


def servo_stage(
    source: Source,
    model: Model,
    recordings: Sequence[tuple[str, Recording]],
    raw: Sequence[tuple[str, Recording]],
    filtering: Filtering,
    judge: Judge,
) -> ServoStage:
    """Identify the servos from the runs that are not held out, and write what differs into the file.

    Args:
        source: The file.
        model: The arm that it describes.
        recordings: Role and recording of each run.
        raw: These recordings, each with a torque.
        filtering: Filters.
        judge: What decides whether the changes are written, on the held-out runs.
    """
    used = [run for role, run in recordings if role != HELD_OUT and "command" in run.signals]
    file = servo_law(compile_mjcf(source.text.decode(), source.folder), model.robot.joints)
    if file is None or not used:
        return unchanged(source, model)
    fitted, held_out = (simulated_runs(raw, filtering, judging) for judging in (False, True))
    fit, training, judged = _identified(used, model, file), Trial(source, model, fitted, POSITION), source
    try:
        if model.robot.servo is None:
            fit = with_simulated_gains(with_simulated_limits(fit, training, file), training, file)
            changes = servo_changes(fit, file)
        else:  # its gains are drive gains, which are identified with the arm
            judged, law = _with_stated_gains(source, model, file, fit)
            fit = with_simulated_delay(fit, replace(training, source=judged), law)
            changes = delay_changes(fit, file)
        stages = list(_versions(judged, model, file, fit, changes))
    except ExidynError as error:
        return replace(unchanged(source, model), gain=Gain.SAME, reason=" ".join(str(error).split()))
    stage = min(stages, key=lambda stage: _distance(stage, model, fitted)) if len(stages) > 1 else stages[0]
    if not stage.changes:
        return replace(stage, source=source)
    trial = Trial(judged, model, held_out, POSITION, stage.held)
    gain = judge.compared(trial.distances(judged.text), trial.distances(stage.source.text))
    if gain is Gain.WORSE:
        return replace(unchanged(source, model), held=stage.held, gain=gain, reason=FARTHER)
    return replace(stage, gain=gain, source=_written(source, model.robot.joints, file, stage.changes))


def _with_stated_gains(
    source: Source, model: Model, file: ServoLaw, fit: ServoFit
) -> tuple[Source, ServoLaw]:
    """The file with servos of stated drive gains, and with damping in the ratio that the runs show.

    A delay can only be judged beside gains that are nearly right, and those of the file may be arbitrary.
    """
    robot = model.robot
    assert robot.servo is not None
    stiffness = robot.drive_gain * robot.servo.gain
    ratio = fit.law.damping / fit.law.stiffness
    ratio = np.where(np.isfinite(ratio), np.maximum(ratio, 0.0), file.damping / file.stiffness)
    law = replace(file, stiffness=stiffness, damping=stiffness * ratio)
    fields = {QUANTITIES[KP], QUANTITIES[KV]}
    text = with_servo_law(source.text, source.folder, source.where, robot.joints, law, fields)
    return source._replace(text=text), law


def with_tuned_delay(
    servos: ServoStage, training: Trial, text: bytes, start: tuple[np.ndarray, np.ndarray]
) -> ServoStage:
    """The stage with delays that bring simulations nearest to the training runs; unchanged without delays.

    Torque is sampled somewhere within a cycle; the motion tells the delay more finely. `text` is the file
    with identified gains, and `start` has its joint numbers with identified friction, shape (3, n), and their
    standard deviations.
    """
    if not any(change.quantity == DELAY for change in servos.changes):
        return servos
    source, joints = servos.source, training.model.robot.joints
    shift = Refinement(training, text, *start, np.ones(start[0].shape)).delay_shift()
    changes = tuple(
        replace(change, new=max(change.new + shift, 0.0)) if change.quantity == DELAY else change
        for change in servos.changes
    )
    law = servo_law(compile_mjcf(source.text.decode(), source.folder), joints)
    assert law is not None
    return replace(servos, source=_written(source, joints, law, changes), changes=changes)


def _versions(
    source: Source, model: Model, file: ServoLaw, fit: ServoFit, changes: tuple[ServoChange, ...]
) -> Iterator[ServoStage]:
    """The file for commands that are interpolated; and for held ones, if periods are long."""
    joints, delay = model.robot.joints, changed_law(file, changes).delay
    yield ServoStage(_written(source, joints, file, changes), changes, delay, False)
    if fit.period > SLOW:
        held = _held(changes, fit.period)
        delay = np.maximum(delay, 0.5 * fit.period)
        yield ServoStage(_written(source, joints, file, held), held, delay, True)


def _identified(recordings: Sequence[Recording], model: Model, file: ServoLaw) -> ServoFit:
    """Servos by measured torque; by the torque of the model's bodies where none was measured."""
    runs = [ServoRun.of(run, model.robot.drive_gain) for run in recordings]
    if not any(is_servo_error(run.settings) for run in recordings):
        return identify_servos(runs)
    stated, free = (
        identify_servos([run.with_model_torque(model, rotor_inertia=stated) for run in runs])
        for stated in (True, False)
    )
    fit = free if np.any(free.residual**2 < HALVED * stated.residual**2) else stated
    return _with_other_masses(runs, model, fit, file)


def _with_other_masses(runs: Sequence[ServoRun], model: Model, fit: ServoFit, file: ServoLaw) -> ServoFit:
    """The fit, with the stiffness of the file for joints that other masses explain much better."""
    free = [run.with_free_masses(model) for run in runs]
    laws = [identify_unscaled(free, joint, float(delay)) for joint, delay in enumerate(fit.law.delay)]
    more = len(free[0].unknown) - len(runs[0].unknown)
    ratio = np.array([law.residual for law in laws]) ** 2 / fit.residual**2
    # Bayesian information criterion: blocks are independent samples, and other masses bring these numbers
    doubtful = ratio < BLOCKS ** (-more / BLOCKS)
    damping, std = (file.stiffness * [getattr(law, name) for law in laws] for name in ("damping", "std"))
    return replace(
        fit,
        law=replace(fit.law, damping=np.where(doubtful, damping, fit.law.damping)),
        std=replace(fit.std, damping=np.where(doubtful, std, fit.std.damping)),
        doubtful=doubtful,
    )


def _held(changes: tuple[ServoChange, ...], period: float) -> tuple[ServoChange, ...]:
    """Changes for commands that are held, which by itself delays them by half a period."""
    shifted = [
        replace(change, new=change.new - 0.5 * period) if change.quantity == DELAY else change
        for change in changes
    ]
    return tuple(change for change in shifted if change.quantity != DELAY or change.new > LEAST * period)


def _written(
    source: Source, joints: Sequence[str], file: ServoLaw, changes: tuple[ServoChange, ...]
) -> Source:
    if not changes:
        return source
    fields = {QUANTITIES[change.quantity] for change in changes}
    law = changed_law(file, changes)
    return source._replace(text=with_servo_law(source.text, source.folder, source.where, joints, law, fields))


def _distance(stage: ServoStage, model: Model, runs: Sequence[Run]) -> float:
    """Rms error of the joints over whole runs, relative to their motion."""
    distances = Trial(stage.source, model, runs, POSITION, stage.held).distances(stage.source.text)
    moved = np.std(np.concatenate([run.position for run in runs]), axis=0)
    return float(np.sqrt(np.mean((distances.whole_run / np.maximum(moved, np.finfo(float).tiny)) ** 2)))
