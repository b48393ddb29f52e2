"""The gap between a user's MuJoCo simulation and the real arm: how wide, and what each finding closes of it.

Findings are added one after the other, each with all numbers fitted again. One stays if in the runs held out
none of its joints is worse for it, and no joint at all worse than by the file as it was.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from threadpoolctl import threadpool_limits

from ..diagnosis.candidates import kind_of
from ..diagnosis.diagnose import diagnosed
from ..diagnosis.findings.diagnosis import Diagnosis
from ..diagnosis.findings.finding import Finding
from ..diagnosis.improved.improved import as_found, as_nominal, with_finding
from ..diagnosis.runs.usable import HELD_OUT
from ..diagnosis.words.sentences import sentence
from ..errors import RecordingError
from ..model import Model
from ..plausible.gate import doubts
from ..plausible.servo_gains import servo_gain_doubts
from ..preparation.prepare import Filtering
from ..progress import StageText
from ..recordings.recording import Recording
from ..recordings.servo_error import is_servo_error
from ..robot_files.mjcf import compile_mjcf
from ..robot_files.mjcf_drives import servo_stiffness
from .distances import Distances, horizons_of
from .ladder import Ladder, Source, Stage, Step, simulated
from .replay import Run, what_is_commanded
from .servo_torque import with_servo_torque


@dataclass(frozen=True, eq=False)
class Gap:
    """What was found.

    Attributes:
        diagnosis: Of the runs.
        commands: What was commanded, "position" or "torque".
        horizons: [s].
        runs: Those held out.
        before: By the file as it was.
        stages: In the order in which they were tried.
        after: With all that is kept; `before` where nothing is.
        kept: The arm with that; None where nothing is.
        taken_out: What of the findings is of the measurement, and was taken out of the recordings, in words.
        beyond: What no simulated arm holds, in words.
    """

    diagnosis: Diagnosis
    commands: str
    horizons: tuple[float, ...]
    runs: tuple[Run, ...]
    before: Distances
    stages: tuple[Stage, ...]
    after: Distances
    kept: Step | None
    taken_out: tuple[str, ...]
    beyond: tuple[str, ...]


def gap(
    source: Source,
    model: Model,
    recordings: Sequence[tuple[str, Recording]],
    commands: str = "",
    filtering: Filtering = Filtering(),  # noqa: B008
    progress: Callable[[str], None] = lambda _: None,
    as_recorded: bool = False,
) -> Gap:
    """Simulate, diagnose, write what was found, simulate again.

    Args:
        source: The MJCF.
        model: What it describes, with the drive gains of the recordings.
        recordings: Role and recording of each run; those of role "validate" judge.
        commands: "position" or "torque"; what file and runs have, by default.
        filtering: Filters; chosen from the data where none is given.
        progress: Called with a sentence at each stage.
        as_recorded: Take columns, units and signs as they are stated, without a check.

    Raises:
        RecordingError: No run is held out.
        ExidynError: The runs cannot be used; the message gives the reason.
    """
    if not any(role == HELD_OUT for role, _ in recordings):
        raise RecordingError("no run judges what is gained: give one that is not fitted, --validate RUN")
    compiled = _compiled(source)
    suspicions = [] if as_recorded else _suspicions(compiled, model, recordings)
    as_recorded = as_recorded or any(is_servo_error(one.settings) for _, one in recordings)
    recordings = [(role, with_servo_torque(compiled, one, model.robot.joints)) for role, one in recordings]
    diagnosis = diagnosed(
        model, recordings, model.robot.name, filtering, progress, as_recorded=as_recorded
    ).diagnosis
    diagnosis = replace(diagnosis, suspicions=(*diagnosis.suspicions, *suspicions))
    held, faults, beyond = _sorted(diagnosis)
    runs = tuple(
        Run.of(_without(one, diagnosis, faults), filtering) for role, one in recordings if role == HELD_OUT
    )
    commands = what_is_commanded(compiled, runs, model.robot.joints, commands)
    progress(StageText("simulate", "simulate the file as it is"))
    before = simulated(source, source.text, model, runs, commands, attach=False)
    ladder = Ladder(source, recordings, filtering, diagnosis, runs, commands, faults, before)
    with threadpool_limits(limits=1):  # steps of one arm are small: threads would wait for one another
        ladder.climb(held, progress)
    joints = diagnosis.joints
    return Gap(
        diagnosis, commands, horizons_of(runs), runs, before, tuple(ladder.stages), ladder.last, ladder.kept,
        tuple(sentence(one, joints) for one in faults), tuple(sentence(one, joints) for one in beyond),
    )  # fmt: skip


def _suspicions(compiled: object, model: Model, recordings: Sequence[tuple[str, Recording]]) -> list[str]:
    """What may be wrong with logs of commands alone.

    Asked of the torque that a servo in an arm gives: with what MuJoCo's steps make of its damping, a light
    joint may have an inertia below zero, which is a mistake in an arm.

    """
    if not any(is_servo_error(one.settings) for _, one in recordings):
        return []
    joints = model.robot.joints
    runs = [run for _, run in recordings]
    stiffness = None if model.robot.servo is not None else servo_stiffness(compiled, joints)
    if stiffness is not None and (wrong := servo_gain_doubts(runs, model, stiffness)):
        return wrong
    return doubts([with_servo_torque(compiled, run, joints, 0.0) for run in runs], model)


def _sorted(diagnosis: Diagnosis) -> tuple[list[Finding], list[Finding], list[Finding]]:
    """Findings that a simulated arm holds, those of the measurement, and those that neither is."""
    held, faults, beyond = [], [], []
    nominal = None if diagnosis.evidence is None else as_nominal(diagnosis.evidence)
    for finding in diagnosis.findings:
        kind = kind_of(finding.effect)
        if nominal is None or with_finding(nominal, finding) is None:
            beyond.append(finding)
        elif kind.sensor:
            faults.append(finding)
        else:
            held.append(finding)
    return held, faults, beyond


def _without(recording: Recording, diagnosis: Diagnosis, faults: Sequence[Finding]) -> Recording:
    """The recording with a model that takes these findings out of it."""
    if diagnosis.evidence is None:
        return recording
    held = as_found(diagnosis.evidence, faults).model.measurements
    return replace(recording, model=replace(recording.model, measurements=held))


def _compiled(source: Source) -> object:
    return compile_mjcf(source.text.decode(), source.folder)
