"""The gap between a user's MuJoCo simulation and the real arm: how wide, and what each finding closes of it.

Findings are added one after the other, each with all numbers fitted again. One stays if in the runs held out
none of its joints is worse for it, and no joint at all worse than by the file as it was.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from ..diagnosis.candidates import kind_of
from ..diagnosis.diagnose import diagnosed
from ..diagnosis.findings.finding import Diagnosis, Finding
from ..diagnosis.improved.improved import as_found, as_nominal, with_finding
from ..diagnosis.refit import refit, undone
from ..diagnosis.runs.usable import HELD_OUT
from ..diagnosis.words.naming import named
from ..diagnosis.words.sentences import sentence
from ..errors import ExidynError, RecordingError
from ..export.mjcf_changes import Change
from ..export.mjcf_gears import Gear, add_gears
from ..export.mjcf_patch import patch
from ..export.portable import Portable
from ..fit.fit import Fit
from ..fit.identified import identified, standard_parameters
from ..input_check.gate import require_plausible
from ..model import Model
from ..preparation.prepare import Filtering
from ..recordings.recording import Recording
from ..recordings.servo_error import is_servo_error
from ..robot_files.mjcf import compile_mjcf
from ..text_table import NORMAL_95
from .distances import Distances, distances, horizons_of
from .gear_torque import without_gears
from .replay import Run, Simulator, what_is_commanded
from .servo_torque import with_servo_torque

NUMBERS = "numbers that MJCF has: masses, inertia, armature, damping, friction"
SURE = 1.64
"""Standard errors by which a joint is worse with 95 %."""


class Source(NamedTuple):
    """The user's file: its text, the folder in which its files lie, and what errors call it."""

    text: bytes
    folder: str
    where: str


class Stage(NamedTuple):
    """One finding, added to those that were kept before it.

    Attributes:
        name: In words.
        distances: With it; None where it could not be simulated.
        worse: Joints that are worse for it, from 0.
        reason: Why it is not written; empty where it is.
    """

    name: str
    distances: Distances | None
    worse: tuple[int, ...] = ()
    reason: str = ""


class Step(NamedTuple):
    """An arm that can be simulated, and the file that holds what it can of it."""

    fit: Fit
    arm: Model
    text: bytes
    changes: tuple[Change, ...]
    left: tuple[str, ...]


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
        as_recorded: Take columns, units and signs as they are stated, however unlikely.

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
    runs = tuple(Run.of(undone(one, faults), filtering) for role, one in recordings if role == HELD_OUT)
    commands = what_is_commanded(compiled, runs, model.robot.joints, commands)
    progress("simulate the file as it is")
    before = _distances(source, source.text, model, runs, commands, attach=False)
    ladder = _Ladder(source, recordings, filtering, diagnosis, runs, commands, faults, before)
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

    Raises:
        WrongInput: They are surely in other units or signs than stated.
    """
    if not any(is_servo_error(one.settings) for _, one in recordings):
        return []
    joints = model.robot.joints
    return require_plausible([with_servo_torque(compiled, one, joints, 0.0) for _, one in recordings], model)


def _sorted(diagnosis: Diagnosis) -> tuple[list[Finding], list[Finding], list[Finding]]:
    """Findings that a simulated arm holds, those of the measurement, and those that neither is."""
    held, faults, beyond = [], [], []
    nominal = None if diagnosis.evidence is None else as_nominal(diagnosis.evidence)
    for finding in diagnosis.findings:
        kind = kind_of(finding.effect)
        if kind.undo is not None:
            faults.append(finding)
        elif nominal is None or with_finding(nominal, finding) is None:
            beyond.append(finding)
        else:
            held.append(finding)
    return held, faults, beyond


def _compiled(source: Source) -> object:
    return compile_mjcf(source.text.decode(), source.folder)


def _distances(
    source: Source, text: bytes, arm: Model, runs: Sequence[Run], commands: str, attach: bool
) -> Distances:
    with Simulator(text.decode(), source.folder, arm, commands, attach) as simulator:
        return distances(simulator, arm.robot, runs)


@dataclass
class _Ladder:
    """Findings, one added after the other."""

    source: Source
    recordings: Sequence[tuple[str, Recording]]
    filtering: Filtering
    diagnosis: Diagnosis
    runs: Sequence[Run]
    commands: str
    faults: Sequence[Finding]
    before: Distances

    def __post_init__(self) -> None:
        self.stages: list[Stage] = []
        self.last, self.kept = self.before, None  # type: Distances, Step | None

    def climb(self, findings: Sequence[Finding], progress: Callable[[str], None]) -> None:
        """Try the numbers alone, then each finding."""
        kept: list[Finding] = []
        joints = self.diagnosis.joints
        for one in (None, *findings):
            name = NUMBERS if one is None else named(one.effect, one.joints, joints)
            progress(f"simulate with {name}")
            if self._try(name, [*kept, one] if one else kept, one.joints if one else ()):
                kept += [one] if one else []

    def _try(self, name: str, findings: Sequence[Finding], own: Sequence[int]) -> bool:
        """Add a stage of a finding that acts on some joints; whether it is kept."""
        try:
            step = self._step(findings)
            found = _distances(self.source, step.text, step.arm, self.runs, self.commands, attach=True)
        except ExidynError as error:
            self.stages.append(Stage(name, None, (), " ".join(str(error).split())))
            return False
        worse = worse_joints(self.before, self.last, found, self._noise(), own)
        if not worse:
            self.last, self.kept = found, step
        words = ", ".join(self.diagnosis.joints[joint] for joint in worse)
        self.stages.append(Stage(name, found, worse, f"{words} would be worse" if worse else ""))
        return not worse

    def _noise(self) -> np.ndarray:
        return np.asarray(np.max([run.noise for run in self.runs], axis=0))

    def _step(self, findings: Sequence[Finding]) -> Step:
        """Numbers fitted beside findings, and the file with what it can hold."""
        evidence, recordings = self.diagnosis.evidence, self.recordings
        if evidence is not None:
            recordings = [(role, without_gears(one, role, evidence, findings)) for role, one in recordings]
        diagnosis = replace(self.diagnosis, findings=(*self.faults, *findings))
        fit = refit(diagnosis, recordings, filtering=self.filtering)
        if fit is None:
            raise ExidynError("the diagnosis has no evidence")
        arm = identified(fit)
        source = self.source
        made = patch(Portable.of(arm), standard_parameters(fit), source.text, source.folder, source.where)
        gears = gears_of(self.diagnosis, findings)
        text, more = add_gears(made.text, source.folder, source.where, gears)
        return Step(fit, arm, text, (*made.changes, *more), made.left)


def gears_of(diagnosis: Diagnosis, findings: Sequence[Finding]) -> list[Gear]:
    """Gears that give way by some of a diagnosis' findings."""
    if diagnosis.evidence is None:
        return []
    gears = as_found(diagnosis.evidence, findings).transmission
    return [
        Gear(
            diagnosis.joints[joint],
            float(gears.stiffness[joint]),
            float(gears.damping[joint]),
            float(gears.backlash[joint]),
            float(gears.stiffness[joint]) * _relative_half(findings, joint, "stiffness", "share"),
            float(gears.backlash[joint]) * _relative_half(findings, joint, "gap"),
        )
        for joint in gears.elastic.tolist()
    ]


def _relative_half(findings: Sequence[Finding], joint: int, *names: str) -> float:
    """Half of the 95 % interval of a product of what was found of a gear, over it; infinite without."""
    for one in findings:
        if kind_of(one.effect).gear and joint in one.joints and names[0] in one.parameters:
            found = [one.parameters[name] for name in names]
            half = NORMAL_95 * float(np.linalg.norm([each.std / each.value for each in found]))
            return half if np.isfinite(half) else np.inf
    return np.inf


def worse_joints(
    first: Distances, last: Distances, now: Distances, noise: np.ndarray, own: Sequence[int]
) -> tuple[int, ...]:
    """Joints that are farther off, from 0, after the longest horizon that tells anything of them.

    Any joint than by the file as it was, by more than the encoder's noise (n,) [rad]. A joint on which the
    finding acts than before it, by more than the starts vary, with 95 %; others move with it, for better or
    worse, as long as findings are missing.
    """
    every = np.arange(len(noise))
    squares = [one.ends[:, last.telling, every] ** 2 for one in (last, now)]
    with np.errstate(invalid="ignore"):
        more = squares[1] - squares[0]
        error = np.std(more, axis=0) / np.sqrt(len(more))
        surely = np.nan_to_num(np.mean(more, axis=0) - SURE * error) > 0.0
    acting = np.isin(every, own)
    beyond = ~(now.joints[first.telling, every] <= first.joints[first.telling, every] + noise)
    return tuple(int(joint) for joint in np.flatnonzero(acting & surely | beyond))
