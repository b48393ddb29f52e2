"""Ladder: findings added to the file one after the other, each kept where it makes nothing worse."""

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
        nearer: Of the joints on which it acts, or of all, those that are nearer to the real arm for it, with
            95 %, from 0.
        reason: Why it is not written; empty where it is.
    """

    name: str
    distances: Distances | None
    worse: tuple[int, ...] = ()
    nearer: tuple[int, ...] = ()
    reason: str = ""


class Step(NamedTuple):
    """An arm that can be simulated, and the file that holds what it can of it."""

    fit: Fit
    arm: Model
    text: bytes
    changes: tuple[Change, ...]
    left: tuple[str, ...]


def simulated(
    source: Source, text: bytes, arm: Model, runs: Sequence[Run], commands: str, attach: bool
) -> Distances:
    """How far an arm in MuJoCo, by a text of the source, and the runs part."""
    with Simulator(text.decode(), source.folder, arm, commands, attach) as simulator:
        return distances(simulator, arm.robot, runs)


@dataclass
class Ladder:
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
            progress(StageText("simulate", f"simulate with {name}"))
            if self._try(name, [*kept, one] if one else kept, one.joints if one else ()):
                kept += [one] if one else []

    def _try(self, name: str, findings: Sequence[Finding], own: Sequence[int]) -> bool:
        """Add a stage of a finding that acts on some joints; whether it is kept."""
        try:
            step = self._step(findings)
            found = simulated(self.source, step.text, step.arm, self.runs, self.commands, attach=True)
        except ExidynError as error:
            self.stages.append(Stage(name, None, reason=" ".join(str(error).split())))
            return False
        worse = worse_joints(self.before, self.last, found, self._noise(), own)
        nearer = tuple(one for one in nearer_joints(self.last, found) if one in own or not len(own))
        if not worse:
            self.last, self.kept = found, step
        words = ", ".join(self.diagnosis.joints[joint] for joint in worse)
        self.stages.append(Stage(name, found, worse, nearer, f"{words} would be worse" if worse else ""))
        return not worse

    def _noise(self) -> np.ndarray:
        return np.asarray(np.max([run.noise for run in self.runs], axis=0))

    def _step(self, findings: Sequence[Finding]) -> Step:
        """Numbers fitted beside findings, and the file with what it can hold."""
        diagnosis = replace(self.diagnosis, findings=(*self.faults, *findings))
        fit = refit(diagnosis, self.recordings, filtering=self.filtering)
        if fit is None:
            raise ExidynError("the diagnosis has no evidence")
        arm = replace(identified(fit), measurements=())  # gears are added below, sensors are not simulated
        source = self.source
        made = patch(Portable.of(arm), standard_parameters(fit), source.text, source.folder, source.where)
        gears = gears_of(self.diagnosis, findings)
        text, more = add_gears(made.text, source.folder, source.where, gears)
        return Step(fit, arm, text, (*made.changes, *more), made.left)


def gears_of(diagnosis: Diagnosis, findings: Sequence[Finding]) -> list[Gear]:
    """Gears that give way by some of a diagnosis' findings."""
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
    acting, surely = np.isin(every, own), _farther(last, now) > SURE
    beyond = ~(now.joints[first.telling, every] <= first.joints[first.telling, every] + noise)
    return tuple(int(joint) for joint in np.flatnonzero(acting & surely | beyond))


def nearer_joints(last: Distances, now: Distances) -> tuple[int, ...]:
    """Joints that are nearer to the real arm, from 0, by more than the starts vary, with 95 %."""
    return tuple(int(joint) for joint in np.flatnonzero(_farther(last, now) < -SURE))


def _farther(last: Distances, now: Distances) -> np.ndarray:
    """By how many standard errors each joint's mean square has grown, shape (n,); 0 where it diverged."""
    every = np.arange(last.ends.shape[2])
    before, after = (one.ends[:, last.telling, every] ** 2 for one in (last, now))
    with np.errstate(invalid="ignore", divide="ignore"):
        more = after - before
        error = np.std(more, axis=0) / np.sqrt(len(more))
        return np.asarray(np.nan_to_num(np.mean(more, axis=0) / error, posinf=np.inf, neginf=-np.inf))
