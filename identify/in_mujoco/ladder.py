"""Ladder: findings added to the file one after the other, each kept if it makes no joint worse."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..diagnosis.candidates import kind_of
from ..diagnosis.findings.diagnosis import Diagnosis
from ..diagnosis.findings.finding import Finding
from ..diagnosis.improved.improved import as_found
from ..diagnosis.refit import refit
from ..diagnosis.words.naming import named
from ..errors import ExidynError
from ..export.mjcf_changes import Change
from ..export.mjcf_gears import Gear, add_gears
from ..export.mjcf_patch import patch
from ..export.portable import Portable
from ..fit.fit import Fit
from ..fit.identified import identified, standard_parameters
from ..model import Model
from ..preparation.prepare import Filtering
from ..progress import StageText
from ..recordings.recording import Recording
from ..simulation.plant import Transmission
from ..text_table import NORMAL_95
from .distances import Distances, distances
from .replay import Run, Simulator

NUMBERS = "numbers that MJCF has: masses, inertia, armature, damping, friction"
SURE = 1.64
"""Number of standard errors by which a joint is worse with 95 % confidence (one-sided)."""


class Source(NamedTuple):
    """The user's file: its text, the folder of the files that it refers to, and its name in errors."""

    text: bytes
    folder: str
    where: str


class Stage(NamedTuple):
    """One finding, added to those that were kept before it.

    Attributes:
        name: The finding in words.
        distances: Distances with the finding; None if it could not be simulated.
        worse: Joints that the finding makes worse, from 0.
        nearer: Joints that the finding brings nearer to the real arm, with 95 % confidence, from 0; only
            joints on which it acts, or any joint if it acts on all.
        reason: Why the finding is not written; empty if it is written.
    """

    name: str
    distances: Distances | None
    worse: tuple[int, ...] = ()
    nearer: tuple[int, ...] = ()
    reason: str = ""


class Step(NamedTuple):
    """An arm that can be simulated, and the file with everything of it that MJCF can express."""

    fit: Fit
    arm: Model
    text: bytes
    changes: tuple[Change, ...]
    left: tuple[str, ...]


def simulated(
    source: Source, text: bytes, arm: Model, runs: Sequence[Run], commands: str, attach: bool
) -> Distances:
    """Distances between the runs and an arm in MuJoCo, simulated with a version of the source's text."""
    with Simulator(text.decode(), source.folder, arm, commands, attach) as simulator:
        return distances(simulator, arm.robot, runs)


@dataclass
class Ladder:
    """Sequence of findings, each added to those kept before it."""

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
        """Try the parameters of the file alone, then each finding."""
        kept: list[Finding] = []
        joints = self.diagnosis.joints
        for finding in (None, *findings):
            name = NUMBERS if finding is None else named(finding.effect, finding.joints, joints)
            progress(StageText("simulate", f"simulate with {name}"))
            if self._try(name, [*kept, finding] if finding else kept, finding.joints if finding else ()):
                kept += [finding] if finding else []

    def _try(self, name: str, findings: Sequence[Finding], acting: Sequence[int]) -> bool:
        """Add a stage for a finding that acts on some joints, and return whether it is kept."""
        try:
            step = self._step(findings)
            now = simulated(self.source, step.text, step.arm, self.runs, self.commands, attach=True)
        except ExidynError as error:
            self.stages.append(Stage(name, None, reason=" ".join(str(error).split())))
            return False
        worse = worse_joints(self.before, self.last, now, self._noise(), acting)
        nearer = tuple(joint for joint in nearer_joints(self.last, now) if joint in acting or not len(acting))
        if not worse:
            self.last, self.kept = now, step
        words = ", ".join(self.diagnosis.joints[joint] for joint in worse)
        self.stages.append(Stage(name, now, worse, nearer, f"{words} would be worse" if worse else ""))
        return not worse

    def _noise(self) -> np.ndarray:
        return np.asarray(np.max([run.noise for run in self.runs], axis=0))

    def _step(self, findings: Sequence[Finding]) -> Step:
        """Parameters fitted together with the findings, and the file with what MJCF can express of them."""
        diagnosis = replace(self.diagnosis, findings=(*self.faults, *findings))
        fit = refit(diagnosis, self.recordings, filtering=self.filtering)
        if fit is None:
            raise ExidynError("the diagnosis has no evidence to fit the findings to")
        arm = replace(identified(fit), measurements=())  # gears are added below, sensors are not simulated
        source = self.source
        patched = patch(Portable.of(arm), standard_parameters(fit), source.text, source.folder, source.where)
        gears = gears_of(self.diagnosis, findings)
        text, more = add_gears(patched.text, source.folder, source.where, gears)
        return Step(fit, arm, text, (*patched.changes, *more), patched.left)


def gears_of(diagnosis: Diagnosis, findings: Sequence[Finding]) -> list[Gear]:
    """Elastic gears according to some findings of a diagnosis."""
    if diagnosis.evidence is None:
        return []
    gears = Transmission.of(as_found(diagnosis.evidence, findings).model)
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
    """Relative half-width of the 95 % interval of a product of a gear's parameters; infinite if unknown."""
    for finding in findings:
        if kind_of(finding.effect).gear and joint in finding.joints and names[0] in finding.parameters:
            estimates = [finding.parameters[name] for name in names]
            half = NORMAL_95 * float(np.linalg.norm([factor.std / factor.value for factor in estimates]))
            return half if np.isfinite(half) else np.inf
    return np.inf


def worse_joints(
    first: Distances, last: Distances, now: Distances, noise: np.ndarray, acting: Sequence[int]
) -> tuple[int, ...]:
    """Joints whose error has grown, from 0, at the longest horizon at which it is informative.

    A joint on which the finding acts is compared with the previous stage, and its error must have grown by
    more than the starts vary, with 95 % confidence. Other joints react to it, for better or worse, as long as
    findings are missing. They are compared with the original file, by more than the encoder noise (n,) [rad].
    """
    joints = np.arange(len(noise))
    acted_on, grown = np.isin(joints, acting), _growth(last, now) > SURE
    beyond_first = ~(now.joints[first.telling, joints] <= first.joints[first.telling, joints] + noise)
    return tuple(int(joint) for joint in np.flatnonzero(acted_on & grown | beyond_first))


def nearer_joints(last: Distances, now: Distances) -> tuple[int, ...]:
    """Joints whose error has shrunk by more than the starts vary, with 95 % confidence, from 0."""
    return tuple(int(joint) for joint in np.flatnonzero(_growth(last, now) < -SURE))


def _growth(last: Distances, now: Distances) -> np.ndarray:
    """Growth of each joint's mean square error in standard errors, shape (n,); 0 if it diverged in both."""
    joints = np.arange(last.ends.shape[2])
    before, after = (stage.ends[:, last.telling, joints] ** 2 for stage in (last, now))
    with np.errstate(invalid="ignore", divide="ignore"):
        growth = after - before
        error = np.std(growth, axis=0) / np.sqrt(len(growth))
        return np.asarray(np.nan_to_num(np.mean(growth, axis=0) / error, posinf=np.inf, neginf=-np.inf))
