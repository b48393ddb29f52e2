"""Shown: a diagnosis with its samples, new or read from files, as pages show it."""

from typing import NamedTuple

from ..diagnosis.findings.diagnosis import Diagnosis
from ..diagnosis.findings.evidence import Trace
from ..diagnosis.improved.improved import with_files
from ..diagnosis.words.naming import finding_names, joint_words
from ..model import Model


class Shown(NamedTuple):
    """A diagnosis, with its samples if they were kept."""

    diagnosis: Diagnosis  # the diagnosis; its samples are in `traces`
    traces: tuple[Trace, ...] = ()  # samples of runs, held-out runs first; empty if they were not kept
    folder: str = ""  # folder with the models of findings and rivals; empty if they were not written
    model: Model | None = None  # nominal model; None without samples

    @classmethod
    def of(cls, diagnosis: Diagnosis, folder: str = "") -> "Shown":
        """A new diagnosis, with the file names of its alternatives."""
        traces, model = (evidence.traces, evidence.model) if (evidence := diagnosis.evidence) else ((), None)
        if folder:
            diagnosis = with_files(diagnosis)
        return cls(diagnosis, traces, folder, model)

    @property
    def names(self) -> list[str]:
        """Names of the joints in words."""
        joints = self.diagnosis.joints
        return [joint_words(joint, joints) for joint in range(len(joints))]

    @property
    def finding_names(self) -> list[str]:
        """Names of the findings in words, undecided ones last."""
        return finding_names(self.diagnosis)

    @property
    def judged(self) -> tuple[Trace, ...]:
        """Traces of the held-out runs; of all runs without any."""
        return tuple(trace for trace in self.traces if trace.role == "validate") or self.traces

    def noise_of(self, joint: int) -> float | None:
        """Noise floor of a joint's torque behind the filter [N m]; None if it was not measured at rest."""
        diagnosis = self.diagnosis
        return float(diagnosis.noise[joint]) if diagnosis.noise_measured_at_rest else None
