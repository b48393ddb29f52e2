"""The gap between a user's MuJoCo simulation and the real arm: its size, and how much each finding closes.

Findings are added one after the other, and all parameters are fitted again each time. A finding is kept if,
in the held-out runs, it makes none of its joints worse and leaves no joint worse than with the original file.
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
    """The gap between simulation and recordings, and the findings that close it.

    Attributes:
        diagnosis: Diagnosis of the runs.
        commands: What was commanded, "position" or "torque".
        horizons: Times after a start at which both are compared [s].
        runs: Held-out runs.
        before: Distances with the original file.
        stages: Findings in the order in which they were tried.
        after: Distances with all findings that are kept; `before` if there are none.
        kept: The arm with those findings; None if there are none.
        taken_out: Findings about the measurement, which were removed from the recordings, in words.
        beyond: Findings that a simulated arm cannot represent, in words.
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
    """Simulate, diagnose, write the findings into the file, and simulate again.

    Args:
        source: The MJCF.
        model: The arm that it describes, with the drive gains of the recordings.
        recordings: Role and recording of each run; runs of role "validate" decide which findings are kept.
        commands: "position" or "torque"; by default, what the file and the runs support.
        filtering: Filters; by default, they are chosen from the data.
        progress: Function that is called with a sentence at each stage.
        as_recorded: Whether to skip the check of columns, units and signs.

    Raises:
        RecordingError: If no run is held out.
        ExidynError: If the runs cannot be used; the message gives the reason.
    """
    if not any(role == HELD_OUT for role, _ in recordings):
        raise RecordingError(
            "no run is held out to decide which findings help: add one that is not fitted, --validate RUN"
        )
    compiled = _compiled(source)
    suspicions = [] if as_recorded else _suspicions(compiled, model, recordings)
    as_recorded = as_recorded or any(is_servo_error(run.settings) for _, run in recordings)
    recordings = [(role, with_servo_torque(compiled, run, model.robot.joints)) for role, run in recordings]
    diagnosis = diagnosed(
        model, recordings, model.robot.name, filtering, progress, as_recorded=as_recorded
    ).diagnosis
    diagnosis = replace(diagnosis, suspicions=(*diagnosis.suspicions, *suspicions))
    of_arm, faults, beyond = _sorted(diagnosis)
    runs = tuple(
        Run.of(_without(recording, diagnosis, faults), filtering)
        for role, recording in recordings
        if role == HELD_OUT
    )
    commands = what_is_commanded(compiled, runs, model.robot.joints, commands)
    progress(StageText("simulate", "simulate the original file"))
    before = simulated(source, source.text, model, runs, commands, attach=False)
    ladder = Ladder(source, recordings, filtering, diagnosis, runs, commands, faults, before)
    with threadpool_limits(limits=1):  # the steps of one arm are too small for threads to pay off
        ladder.climb(of_arm, progress)
    joints = diagnosis.joints
    return Gap(
        diagnosis, commands, horizons_of(runs), runs, before, tuple(ladder.stages), ladder.last, ladder.kept,
        tuple(sentence(finding, joints) for finding in faults),
        tuple(sentence(finding, joints) for finding in beyond),
    )  # fmt: skip


def _suspicions(compiled: object, model: Model, recordings: Sequence[tuple[str, Recording]]) -> list[str]:
    """Doubts about logs that hold commands but no effort.

    They are checked with the torque of a real servo: MuJoCo's steps change the effect of its damping so
    much that a light joint can have a negative inertia, which in a real arm would be a mistake.
    """
    if not any(is_servo_error(run.settings) for _, run in recordings):
        return []
    joints = model.robot.joints
    runs = [run for _, run in recordings]
    stiffness = None if model.robot.servo is not None else servo_stiffness(compiled, joints)
    if stiffness is not None and (wrong := servo_gain_doubts(runs, model, stiffness)):
        return wrong
    return doubts([with_servo_torque(compiled, run, joints, 0.0) for run in runs], model)


def _sorted(diagnosis: Diagnosis) -> tuple[list[Finding], list[Finding], list[Finding]]:
    """Findings that a simulated arm can represent, findings about the measurement, and all others."""
    of_arm, faults, beyond = [], [], []
    nominal = None if diagnosis.evidence is None else as_nominal(diagnosis.evidence)
    for finding in diagnosis.findings:
        kind = kind_of(finding.effect)
        if nominal is None or with_finding(nominal, finding) is None:
            beyond.append(finding)
        elif kind.sensor:
            faults.append(finding)
        else:
            of_arm.append(finding)
    return of_arm, faults, beyond


def _without(recording: Recording, diagnosis: Diagnosis, faults: Sequence[Finding]) -> Recording:
    """The recording with a model that removes these findings from it."""
    if diagnosis.evidence is None:
        return recording
    measurements = as_found(diagnosis.evidence, faults).model.measurements
    return replace(recording, model=replace(recording.model, measurements=measurements))


def _compiled(source: Source) -> object:
    return compile_mjcf(source.text.decode(), source.folder)
