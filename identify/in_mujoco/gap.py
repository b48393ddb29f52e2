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
from ..recordings.servo_error import is_servo_error
from ..robot_files.mjcf import compile_mjcf
from .answer import Answer, DriveGains, attached, drive_gains, file_alone
from .distances import TOOL, Distances, Judge, horizons_of
from .joint_numbers import ServoChange
from .ladder import Ladder, Stage
from .mujoco_laws import with_servo_torque, with_solver_friction
from .replay import POSITION, Run, what_is_commanded
from .servo_stage import ServoStage, servo_stage, unchanged
from .trial import Recordings, Source, Trial, require_unloaded, simulated_runs

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
    recordings: Recordings,
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
    case = _case(source, model, recordings, commands, filtering, Judge(judge_by))
    by_position = case.commands == POSITION
    with threadpool_limits(limits=1):  # the steps of one arm are too small for threads to pay off
        first = case.servo_stage(case.arm)
        diagnosis, fitted = _diagnosed(first, case.arm, case.runs, filtering, progress, as_recorded)
        of_arm, faults, beyond = _sorted(diagnosis)
        cleaned = case if by_position else case.without(diagnosis, faults)
        judging, fitting = (cleaned.trial(first, held_out) for held_out in (True, False))
        ladder = Ladder(judging, fitted, filtering, diagnosis, faults, case.judge)
        gained = ladder.with_gains(judging)  # gains of servos are torques too
        servos = first if gained is judging or not by_position else case.servo_stage(gained.model)
        trial, training = (
            replace(each, source=servos.source, held=servos.held) for each in (judging, fitting)
        )
        progress(StageText("simulate", "simulate the original file"))
        original, start = trial.distances(source.text), trial.distances(servos.source.text)
        ladder.begin(trial, start)
        ladder.climb(of_arm, progress)
        progress(StageText("refine", "refine the numbers of the file by simulation"))
        file = file_alone(ladder, training, servos if by_position else None)
    servo_stages = (Stage(SERVOS, start, servos.gain, servos.reason),) if servos.gain else ()
    return Gap(
        diagnosis=diagnosis,
        commands=case.commands,
        held=servos.held,
        horizons=horizons_of(trial.runs),
        runs=tuple(trial.runs),
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


@dataclass(frozen=True, eq=False)
class _Case:
    """The file, the arm and the runs between which the gap is."""

    source: Source  # the file
    arm: Model  # the arm that it describes
    runs: Recordings  # runs to which fits are made
    replayed: Recordings  # the same runs with a torque, whose commands are simulated
    commands: str  # what is commanded, "position" or "torque"
    filtering: Filtering  # filters
    judge: Judge  # what a simulation is judged by

    def servo_stage(self, arm: Model) -> ServoStage:
        """Servos of the file, identified with an arm if they follow commanded positions."""
        if self.commands != POSITION:
            return unchanged(self.source, arm)
        return servo_stage(self.source, arm, self.runs, self.replayed, self.filtering, self.judge)

    def trial(self, servos: ServoStage, held_out: bool) -> Trial:
        """Trial of the file with these servos on the held-out or the fitted runs."""
        runs = simulated_runs(self.replayed, self.filtering, held_out)
        return Trial(servos.source, self.arm, runs, self.commands, servos.held)

    def without(self, diagnosis: Diagnosis, faults: Sequence[Finding]) -> "_Case":
        """The case without these findings about the measurement in the replayed runs."""
        if diagnosis.evidence is None:
            return self
        measurements = as_found(diagnosis.evidence, faults).model.measurements
        replayed = [
            (role, replace(run, model=replace(run.model, measurements=measurements)))
            for role, run in self.replayed
        ]
        return replace(self, replayed=replayed)


def _case(
    source: Source, model: Model, recordings: Recordings, commands: str, filtering: Filtering, judge: Judge
) -> _Case:
    """The case of a file, an arm and runs, with the laws of MuJoCo."""
    compiled, joints = compile_mjcf(source.text.decode(), source.folder), model.robot.joints
    runs = [(role, replace(run, model=_by_servos_of_file(run.model))) for role, run in recordings]
    # Simulations take the commands of the log. Its effort counts only if torque is commanded.
    replayed = [(role, with_servo_torque(compiled, run, joints)) for role, run in runs]
    commanded = what_is_commanded(compiled, [run for _, run in replayed], joints, commands)
    arm = with_solver_friction(_by_servos_of_file(model), compiled)
    return _Case(source, arm, runs, replayed, commanded, filtering, judge)


def _by_servos_of_file(model: Model) -> Model:
    """The arm without stated servos: those of a proposed robot file have gains of 1, which nobody knows."""
    return replace(model, robot=replace(model.robot, servo=None))


def _diagnosed(
    servos: ServoStage,
    model: Model,
    recordings: Recordings,
    filtering: Filtering,
    progress: Callable[[str], None],
    as_recorded: bool,
) -> tuple[Diagnosis, Recordings]:
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
