"""A diagnosis as its pages show it, whether it was made just now or read from its files."""

from typing import NamedTuple

import numpy as np

from ..diagnosis.findings.finding import Diagnosis, Moment, Trace
from ..diagnosis.improved.forward import Forward
from ..diagnosis.words.diagnosis_file import array_of, diagnosis_file, value_of
from ..diagnosis.words.diagnosis_schema import DiagnosisFile, FindingRow
from ..diagnosis.words.naming import joint_words, named


class Diagnosed(NamedTuple):
    """All but samples, and the samples as far as they were kept.

    Attributes:
        file: All but samples.
        noise: Noise floor of each joint's torque behind the filter, shape (n,) [N m]; empty if not known.
        traces: Samples of runs, those held out first; none if they were not kept.
        forward: Samples of the simulated run; None if nothing was simulated or they were not kept.
    """

    file: DiagnosisFile
    noise: np.ndarray
    traces: tuple[Trace, ...] = ()
    forward: Forward | None = None

    @classmethod
    def of(cls, diagnosis: Diagnosis, forward: Forward | None = None, folder: str = "") -> "Diagnosed":
        """Made just now; with the folder in which models of findings and rivals are written."""
        file, known = diagnosis_file(diagnosis, forward, folder), diagnosis.evidence
        noise = array_of(file.noise) if known is None else known.noise
        return cls(file, noise, known.traces if known else (), forward)

    @property
    def names(self) -> list[str]:
        """Its joints in words."""
        return [joint_words(joint, self.file.joints) for joint in range(len(self.file.joints))]

    @property
    def judged(self) -> tuple[Trace, ...]:
        """Runs held out, or else all."""
        return tuple(trace for trace in self.traces if trace.role == "validate") or self.traces

    @property
    def over_noise(self) -> bool:
        """Whether noise was measured at rest, so that numbers may be given as multiples of it."""
        return self.file.noise_measured_at_rest

    def noise_of(self, joint: int) -> float | None:
        """Noise floor of a joint; None where it was not measured."""
        return float(self.noise[joint]) if self.over_noise and len(self.noise) else None

    @property
    def residuals(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Residual of runs held out, by the model fitted without and with findings; None without runs."""
        file = self.file
        if file.budget is not None and file.budget.held_out:
            return array_of(file.budget.before_rms), array_of(file.budget.after_rms)
        if file.torque_rms_before is None:
            return None
        return array_of(file.torque_rms_before), array_of(file.torque_rms_after)

    def clearest_joint(self, finding: FindingRow) -> int:
        """The joint on which the finding is seen best: of those that feel it, where most was gained."""
        torque = array_of(finding.torque_rms)
        if self.residuals is None or not len(self.noise):
            return int(np.argmax(torque))
        before, after = self.residuals
        return int(np.argmax(np.where(torque > 0.0, (before - after) / self.noise, -np.inf)))


def moments(file: DiagnosisFile) -> list[Moment]:
    """Times at which a run differs from the model as at no other."""
    return [
        Moment(
            one.run, value_of(one.start), value_of(one.end), tuple(joint - 1 for joint in one.joints),
            array_of(one.direction), value_of(one.force),
        )
        for one in file.moments
    ]  # fmt: skip


def name_of_finding(diagnosis: Diagnosed, finding: FindingRow) -> str:
    """The effect and where it acts, in words."""
    return finding.name or named(finding.effect, finding.places, diagnosis.file.joints)
