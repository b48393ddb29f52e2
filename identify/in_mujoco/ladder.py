"""Ladder: findings added to the file one after the other, each kept unless it moves the simulation away."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ..diagnosis.candidates import kind_of
from ..diagnosis.findings.diagnosis import Diagnosis
from ..diagnosis.findings.finding import Finding
from ..diagnosis.improved.improved import as_found
from ..diagnosis.refit import refit
from ..diagnosis.words.naming import named
from ..effects import JointEffect, RotorInertia, name_of
from ..errors import ExidynError
from ..export.changes import Change
from ..export.mjcf_gears import Gear, add_gears
from ..export.mjcf_patch import patch
from ..export.portable import Portable
from ..fit.fit import Fit
from ..fit.identified import Standard, identified, standard_parameters
from ..fit.needed_changes import needed_changes
from ..model import Model
from ..preparation.prepare import Filtering
from ..progress import StageText
from ..simulation.plant import Transmission
from ..text_table import NORMAL_95
from .distances import Distances, Gain, Judge
from .replay import TORQUE
from .trial import Recordings, Trial

NUMBERS = "numbers of the file (masses, inertia, armature, damping, friction)"
NEGLIGIBLE = "its size, fitted together with the others, cannot be told from zero"
GAINS = "drive gains"
FARTHER = "the simulation would be farther from the recordings"
TOGETHER = "alone they move the simulation away; the numbers below come with them"
SAME_GAIN = 1e-6
"""Relative difference of drive gains that is only rounding."""


class Stage(NamedTuple):
    """Something added to what was kept before it."""

    name: str  # the finding in words, or the kind of numbers
    distances: Distances | None  # distances with it; None if it was not simulated
    # Whether the simulation is nearer to the recordings with it; None if it was not simulated.
    gain: Gain | None = None
    reason: str = ""  # why it is not written; empty if it is


class Step(NamedTuple):
    """An arm that can be simulated, and the file with everything of it that MJCF can express."""

    fit: Fit
    arm: Model
    text: bytes
    changes: tuple[Change, ...]
    left_out: tuple[str, ...]


@dataclass
class Ladder:
    """Sequence of findings, each added to those kept before it."""

    trial: Trial  # the file, and the runs that judge
    recordings: Recordings  # role and recording of each run
    filtering: Filtering  # filters
    diagnosis: Diagnosis  # diagnosis of the recordings
    faults: Sequence[Finding]  # findings about the measurement, which every fit includes
    judge: Judge  # what a simulation is judged by
    start: Distances = field(init=False)  # distances of the file as it is, which others have to beat
    last: Distances = field(init=False)  # distances of what is kept
    best: Step | None = None  # what is kept; None if it is the file as it is
    findings: list[Finding] = field(default_factory=list)  # findings that are kept
    stages: list[Stage] = field(default_factory=list)  # what was tried
    # Findings that vanish in a fit together with the others.
    negligible: list[Finding] = field(default_factory=list)
    # Fits that were made, by the identities of the findings that they include.
    fits: dict[tuple[int, ...], tuple[Fit, Standard]] = field(default_factory=dict)

    def begin(self, trial: Trial, start: Distances) -> None:
        """Take a version of the file as the one to which findings are added.

        Identified drive gains come first: they belong to the recorded currents, not to the file.
        """
        self.trial, self.start = trial, start
        gained = self.with_gains(trial)
        if trial.commands == TORQUE and gained is not trial:
            now = gained.distances(trial.source.text)
            gain = self.judge.compared(start, now)
            self.stages.append(Stage(GAINS, now, gain, TOGETHER if gain is Gain.WORSE else ""))
            if gain is not Gain.WORSE:
                self.trial, self.start = gained, now
        self.last = self.start

    def with_gains(self, trial: Trial) -> Trial:
        """The trial, with the drive gains that were identified with what is kept; unchanged if none were."""
        try:
            arm = self.best.arm if self.best else self.step(()).arm
        except ExidynError:  # it has a stage with the reason
            return trial
        robot, fields = trial.model.robot, ("drive_gain", "drive_gain_tolerance")
        if np.allclose(arm.robot.drive_gain, robot.drive_gain, rtol=SAME_GAIN, atol=0.0):
            return trial
        robot = replace(robot, **{name: getattr(arm.robot, name) for name in fields})
        return replace(trial, model=replace(trial.model, robot=robot))

    def climb(self, findings: Sequence[Finding], progress: Callable[[str], None]) -> None:
        """Try the numbers of the file, then each finding."""
        for finding in (None, *findings):
            joints = self.diagnosis.joints
            name = NUMBERS if finding is None else named(finding.effect, finding.joints, joints)
            progress(StageText("simulate", f"simulate with {name}"))
            added = [finding] if finding else []
            if self._try(name, [*self.findings, *added], finding):
                self.findings += added

    def _try(self, name: str, findings: Sequence[Finding], finding: Finding | None) -> bool:
        """Add a stage, and return whether it is kept."""
        try:
            step = self.step(findings)
            if finding is not None and _vanished(step.arm, finding):
                self.negligible.append(finding)
                self.stages.append(Stage(name, None, reason=NEGLIGIBLE))
                return False
            if finding is None and not step.changes:
                return False
            now = self.trial.distances(step.text, step.arm, attach=True)
        except ExidynError as error:
            self.stages.append(Stage(name, None, reason=" ".join(str(error).split())))
            return False
        gain = self.judge.compared(self.last, now)
        # Numbers alone are written for their gain; a finding has its evidence in the torque.
        refused = gain is Gain.WORSE or (finding is None and gain is not Gain.BETTER)
        if not refused:
            self.last, self.best = now, step
        self.stages.append(Stage(name, now, gain, FARTHER if gain is Gain.WORSE else ""))
        return not refused

    def step(self, findings: Sequence[Finding]) -> Step:
        """Parameters fitted together with findings, and the file with what MJCF can express of them."""
        fit, standard = self._fit(findings)
        arm = replace(identified(fit, standard), measurements=())  # gears follow; sensors are not simulated
        source = self.trial.source
        # Drive gains belong to the recordings, and have their own table.
        patched = patch(Portable.of(arm), standard, source.text, source.folder, source.where, ("gains",))
        gears = gears_of(self.diagnosis, findings)
        text, more = add_gears(patched.text, source.folder, source.where, gears)
        return Step(fit, arm, text, (*patched.changes, *more), patched.left_out)

    def _fit(self, findings: Sequence[Finding]) -> tuple[Fit, Standard]:
        """Fit with findings, and standard parameters that differ from the file's only where needed."""
        key = tuple(id(finding) for finding in findings)
        if key not in self.fits:
            diagnosis = replace(self.diagnosis, findings=(*self.faults, *findings))
            fit = refit(diagnosis, self.recordings, filtering=self.filtering)
            if fit is None:
                raise ExidynError("the diagnosis has no evidence to fit the findings to")
            standard = needed_changes(fit, standard_parameters(fit), self._numerical(fit.model))
            self.fits[key] = fit, standard
        return self.fits[key]

    def _numerical(self, model: Model) -> np.ndarray:
        """Standard deviations of the parameters, shape (p,), because simulations go in steps."""
        inertia, std = self.trial.numerical_inertia, np.zeros(len(model.nominal_values))
        for effect, columns in zip(model.effects, model.columns, strict=True):
            if isinstance(effect, RotorInertia):
                std[columns] = inertia[effect.columns(model.robot)]
        return std


def _vanished(arm: Model, finding: Finding) -> bool:
    """Whether the effect of a finding has no size in the identified arm."""
    values = [
        value
        for effect, values in arm.shares(arm.nominal_values)
        if name_of(effect) == finding.effect and isinstance(effect, JointEffect)
        if set(effect.columns(arm.robot)) == set(finding.joints)
        for value in values.tolist()
    ]
    return bool(values) and not any(values)


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
