"""Diagnosis: findings, what remains unexplained, and what the findings improve."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from ...model import Model
from ...notebook import InNotebook, counted, optional
from ...result_file import NOT_IN_FILE
from ...schema import Number, Real
from .adequacy import Adequacy
from .beliefs import Beliefs
from .evidence import Budget, Evidence, Remainder
from .finding import Finding

if TYPE_CHECKING:
    from pathlib import Path


@dataclass(frozen=True, eq=False)
class Moment:
    """A time at which a run differs from the model as at no other."""

    run: str  # name of the run
    start: Real  # beginning, in the run's time [s]
    end: Real  # end [s]
    joints: tuple[int, ...]  # joints that differ, from 0
    # Direction of the force on the flange that explains most of it, in the base's axes, shape (3,) [-]; NaN
    # where one joint alone differs.
    direction: np.ndarray
    force: Real  # size of that force [N]


@dataclass(frozen=True, eq=False, kw_only=True)
class Diagnosis(InNotebook):
    """Physics that the model lacks, with evidence, alternatives and undecided effects."""

    name: str  # name of the robot or case
    joints: tuple[str, ...]  # names of the joints
    # Unit of each joint's torque, "N m" or "N"; "A" if no drive gain is known.
    torque_units: tuple[Literal["N m", "N", "A"], ...]
    findings: tuple[Finding, ...]  # certain findings in order of importance; empty if nothing is missing
    undecided: tuple[Finding, ...] = ()  # findings without a certain name, each with its alternatives
    # Joints on which something remains that no effect of the vocabulary explains.
    remainders: tuple[Remainder, ...] = ()
    moments: tuple[Moment, ...] = ()  # times at which a run differs from the model as at no other
    budget: Budget | None = None  # residual of every joint by cause; None for a diagnosis without a budget
    noise: np.ndarray  # noise floor of each joint's torque behind the filter, shape (n,) [N m]
    # Whether sensor noise was measured at rest, so that numbers may be given as multiples of it.
    noise_measured_at_rest: bool = False
    # Residual of the held-out runs without findings, all parameters fitted within their tolerances, as by
    # `identify`, shape (n,) [N m]; None without held-out runs.
    torque_rms_before: np.ndarray | None = None
    # Residual of the held-out runs with findings, all parameters fitted within their tolerances, shape (n,)
    # [N m]; None without held-out runs.
    torque_rms_after: np.ndarray | None = None
    torque_rms_filter_hz: Number | None = None  # cut-off frequency of the comparison [Hz]
    runs: tuple[str, ...]  # names of the fitted runs
    held_out: tuple[str, ...] = ()  # names of the held-out runs
    suspicions: tuple[str, ...] = ()  # suspected mistakes in the recordings or the description, in sentences
    warnings: tuple[str, ...] = ()  # limits of the result, in sentences
    seconds: Number = 0.0  # duration of the diagnosis, reading files not counted [s]
    # Number of hypotheses of each effect that were tested on these runs.
    tried: Mapping[str, int] = field(default_factory=dict)
    # Findings that depend on whether the bodies are as described; None where that was not asked.
    beliefs: Beliefs | None = None
    # Whether the model with all findings fits as correct models fit correct data; None where that was not
    # asked.
    adequacy: Adequacy | None = None
    # Samples and models; None for a diagnosis that was read from its file.
    evidence: Evidence | None = field(default=None, metadata=NOT_IN_FILE)

    if TYPE_CHECKING:  # `exidyn.api` binds these functions of the layers above
        verdict: ClassVar[str]
        model: ClassVar[Model]

        def to_json(self) -> dict[str, Any]: ...
        def save(self, path: Path | str) -> Path: ...
        def report(self, path: Path | str) -> Path: ...

    @property
    def all_findings(self) -> tuple[Finding, ...]:
        """Findings, undecided ones last."""
        return (*self.findings, *self.undecided)

    @property
    def unexplained(self) -> bool:
        """Whether something is missing that has no name here."""
        unnamed = [finding for finding in self.undecided if not finding.family]
        return bool(self.remainders or unnamed) or not all(finding.listed for finding in self.findings)

    def to_dataframe(self) -> Any:
        """Parameters of all findings as a pandas table with one row per parameter.

        Raises:
            MissingPackage: pandas is not installed.
        """
        rows = [
            {
                "effect": finding.effect,
                "joints": ", ".join(self.joints[joint] for joint in finding.joints),
                "parameter": name,
                "value": number.value,
                "std": number.std,
                "low": number.interval[0],
                "high": number.interval[1],
                "unit": number.unit,
                "determined": name not in finding.left_out,
                "probability": finding.probability,
                "named": finding in self.findings,
            }
            for finding in self.all_findings
            for name, number in finding.parameters.items()
        ]
        return optional("pandas", "a table").DataFrame(rows)

    def __repr__(self) -> str:
        number = counted(len(self.findings), "finding")
        lines = [f"Diagnosis of {self.name}: {number}, {len(self.undecided)} undecided"]
        for finding in self.all_findings[:7]:
            where = ", ".join(self.joints[joint] for joint in finding.joints) or "arm"
            state = "" if finding in self.findings else ", undecided"
            lines.append(
                f"  {finding.effect} ({where}): probability {100 * finding.probability:.3g} %{state}"
            )
        unexplained = ", ".join(self.joints[remainder.joint] for remainder in self.remainders)
        lines += [f"  unexplained on: {unexplained}"] if unexplained else []
        return "\n".join(lines)
