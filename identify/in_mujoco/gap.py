"""The gap between a user's MuJoCo simulation and the real arm: its size, and how it closes.

The servos are identified first: without their gains and delays, no other number of the simulation counts.
Then there are two answers. The first is the best file by itself, for simulators that run nothing else. The
second adds the findings of a diagnosis, of which those that MJCF cannot hold act through `exidyn.mujoco`.
Runs that are held out decide what is written.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from threadpoolctl import threadpool_limits

from ..diagnosis.candidates import kind_of
from ..diagnosis.diagnose import diagnose
from ..diagnosis.findings.diagnosis import Diagnosis
from ..diagnosis.findings.finding import Finding
from ..diagnosis.improved.improved import as_found, as_nominal, with_finding
from ..diagnosis.words.sentences import sentence
from ..model import Model
from ..plausible.gate import suspect
from ..preparation.prepare import Filtering
from ..progress import StageText
from ..recordings.recording import Recording
from ..recordings.servo_error import is_servo_error
from ..robot_files.mjcf import compile_mjcf
from .answer import Answer, DriveGains, attached, drive_gains, file_alone
from .distances import TOOL, Distances, Judge, horizons_of
from .joint_numbers import ServoChange
from .ladder import Ladder, Stage
from .mujoco_laws import with_servo_torque, with_solver_friction
from .replay import POSITION, Run, what_is_commanded
from .servo_stage import ServoStage, servo_stage, unchanged
from .trial import Source, Trial, require_unloaded, simulated_runs

SERVOS = "servos of the file (gains, limits, delays of commands)"


@dataclass(frozen=True, eq=False)
class Gap:
    """The gap between simulation and recordings, and what closes it."""

    diagnosis: Diagnosis  # diagnosis of the runs
    commands: str  # what was commanded, "position" or "torque"
    # Whether commands were held from sample to sample in the simulations, rather than interpolated.
    held: bool
    horizons: tuple[float, ...]  # times after a start at which both are compared [s]
    runs: tuple[Run, ...]  # held-out runs
    original: Distances  # distances with the original file
    servos: tuple[ServoChange, ...]  # numbers of the file's servos that changed
    stages: tuple[Stage, ...]  # what was tried, in this order: servos, numbers, findings
    file: Answer  # the best file by itself
    attached: Answer  # the file with the findings, some of which `exidyn.mujoco.attach` adds
    # Findings about the measurement, which were removed from the recordings, in words.
    taken_out: tuple[str, ...]
    beyond: tuple[str, ...]  # findings that a simulated arm cannot represent, in words
    negligible: tuple[Finding, ...] = ()  # findings that vanish in a fit together with the others
    # Drive gains that turn recorded currents into torque; None if no currents were recorded.
    drive_gains: DriveGains | None = None
    # Joints whose stiffness of the servo cannot be determined from these runs.
    undetermined: tuple[int, ...] = ()

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings of the diagnosis that do not vanish in a fit together with the others."""
        return tuple(finding for finding in self.diagnosis.findings if finding not in self.negligible)

    @property
    def changed(self) -> bool:
        """Whether something in the file changes, or effects are attached."""
        return bool(self.servos or self.file.changes or self.attached.attaches)


def gap(
    source: Source,
    model: Model,
    recordings: Sequence[tuple[str, Recording]],
    commands: str = "",
    filtering: Filtering = Filtering(),  # noqa: B008
    progress: Callable[[str], None] = lambda _: None,
    as_recorded: bool = False,
    judge_by: str = TOOL,
) -> Gap:
    """Identify the servos, diagnose the arm, write what was found into the file, and simulate again.

    Args:
        source: The MJCF.
        model: The arm that it describes, with the drive gains of the recordings.
        recordings: Role and recording of each run; runs of role "validate" decide what is written.
        commands: "position" or "torque"; by default, what the file and the runs support.
        filtering: Filters; by default, they are chosen from the data.
        progress: Function that is called with a sentence at each stage.
        as_recorded: Whether to skip the check of columns, units and signs.
        judge_by: "tool" or "joints", whose error decides.

    Raises:
        RecordingError: If no run without a payload is held out, or none is fitted.
        ExidynError: If the runs cannot be used; the message gives the reason.
    """
    require_unloaded(recordings)
    progress(StageText("servos", "identify the servos"))
    judge, compiled = Judge(judge_by), compile_mjcf(source.text.decode(), source.folder)
    joints, arm = model.robot.joints, with_solver_friction(_by_servos_of_file(model), compiled)
    runs = [(role, replace(run, model=_by_servos_of_file(run.model))) for role, run in recordings]
    # Simulations take the commands of the log. Its effort counts only if torque is commanded.
    replayed = [(role, with_servo_torque(compiled, run, joints)) for role, run in runs]
    commanded = what_is_commanded(compiled, [run for _, run in replayed], joints, commands)
    by_position = commanded == POSITION
    with threadpool_limits(limits=1):  # the steps of one arm are too small for threads to pay off
        servos = unchanged(source, arm)
        if by_position:
            servos = servo_stage(source, arm, runs, replayed, filtering, judge)
        diagnosis, fitted = _diagnosed(servos, arm, runs, filtering, progress, as_recorded)
        of_arm, faults, beyond = _sorted(diagnosis)
        if not by_position and diagnosis.evidence is not None:
            measurements = as_found(diagnosis.evidence, faults).model.measurements
            replayed = [
                (role, replace(run, model=replace(run.model, measurements=measurements)))
                for role, run in replayed
            ]
        judging, fitting = (simulated_runs(replayed, filtering, held_out) for held_out in (True, False))
        trial = Trial(servos.source, arm, judging, commanded, servos.held)
        ladder = Ladder(trial, fitted, filtering, diagnosis, faults, judge)
        gained = ladder.with_gains(trial)
        if by_position and gained is not trial:  # gains of servos are torques too
            servos = servo_stage(source, gained.model, runs, replayed, filtering, judge)
        trial = replace(trial, source=servos.source, held=servos.held)
        progress(StageText("simulate", "simulate the original file"))
        original, start = trial.distances(source.text), trial.distances(servos.source.text)
        ladder.begin(trial, start)
        ladder.climb(of_arm, progress)
        progress(StageText("refine", "refine the numbers of the file by simulation"))
        file = file_alone(ladder, replace(trial, runs=fitting), servos if by_position else None)
    servo_stages = (Stage(SERVOS, start, servos.gain, servos.reason),) if servos.gain else ()
    return Gap(
        diagnosis=diagnosis,
        commands=commanded,
        held=servos.held,
        horizons=horizons_of(judging),
        runs=judging,
        original=original,
        servos=servos.changes,
        stages=(*servo_stages, *ladder.stages),
        file=file,
        attached=attached(ladder, file),
        taken_out=tuple(sentence(finding, diagnosis.joints) for finding in faults),
        beyond=tuple(sentence(finding, diagnosis.joints) for finding in beyond),
        negligible=tuple(ladder.negligible),
        drive_gains=drive_gains(ladder, trial),
        undetermined=servos.undetermined,
    )


def _by_servos_of_file(model: Model) -> Model:
    """The arm without stated servos: those of a proposed robot file have gains of 1, which nobody knows."""
    return replace(model, robot=replace(model.robot, servo=None))


def _diagnosed(
    servos: ServoStage,
    model: Model,
    recordings: Sequence[tuple[str, Recording]],
    filtering: Filtering,
    progress: Callable[[str], None],
    as_recorded: bool,
) -> tuple[Diagnosis, list[tuple[str, Recording]]]:
    """Diagnosis, and the recordings to which it applies: with the torque of the servos if none was logged.

    Logs without effort are checked with the torque of a real servo: MuJoCo's steps change the effect of its
    damping so much that a light joint can have a negative inertia, which in a real arm would be a mistake.
    """
    compiled = compile_mjcf(servos.source.text.decode(), servos.source.folder)
    joints, suspicions = model.robot.joints, list[str]()
    without_effort = any(is_servo_error(run.settings) for _, run in recordings)
    if without_effort and not as_recorded:
        suspicion = suspect([with_servo_torque(compiled, run, joints, 0.0) for _, run in recordings], model)
        suspicions += [] if suspicion is None else [f"all runs: {suspicion}"]
    fitted = [
        (role, with_servo_torque(compiled, run, joints, delay=servos.delay)) for role, run in recordings
    ]
    unchecked = as_recorded or without_effort
    diagnosis = diagnose(model, fitted, model.robot.name, filtering, progress, unchecked, brief=True)
    return replace(diagnosis, suspicions=(*diagnosis.suspicions, *suspicions)), fitted


def _sorted(diagnosis: Diagnosis) -> tuple[list[Finding], list[Finding], list[Finding]]:
    """Findings that a simulated arm can represent, findings about the measurement, and all others."""
    of_arm, faults, beyond = [], [], []
    nominal = None if diagnosis.evidence is None else as_nominal(diagnosis.evidence)
    for finding in diagnosis.findings:
        if nominal is None or with_finding(nominal, finding) is None:
            beyond.append(finding)
        elif kind_of(finding.effect).sensor:
            faults.append(finding)
        else:
            of_arm.append(finding)
    return of_arm, faults, beyond
