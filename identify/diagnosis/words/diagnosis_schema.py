"""Schema of diagnosis.json: the types of its fields, and what has to agree between them."""

from collections.abc import Sequence
from typing import Annotated

from msgspec import Meta, Struct

from ...schema import (
    Count,
    EffectName,
    Finite,
    JointNumber,
    Number,
    NumberOrNull,
    Positive,
    Probability,
    Size,
    SizeOrNull,
    check,
    check_different,
    check_joints,
    check_length,
)
from ..findings.located import Hinted, Located
from .size_schema import SizeTable, Unit

Joints = tuple[JointNumber, ...]
PERCENT = 1e4
"""Of a share in the misfit, at most: all together are 100, and what one explains another may take back."""
Percent = Annotated[float, Meta(ge=-PERCENT, le=PERCENT)]
SizeByJoint = tuple[SizeOrNull, ...]


class QuantityRow(Struct, frozen=True):
    """A coefficient or a number of a shape."""

    value: Finite | None
    std: Finite | None
    unit: str


class AlternativeRow(Struct, frozen=True):
    """What the data do not exclude."""

    effect: EffectName
    joints: Joints
    probability: Probability | None


class FindingRow(Struct, frozen=True):
    """A finding, or what is undecided.

    Attributes:
        name: The effect and where it acts, in words; older files lack it.
        headline: What is missing, and what was gained; of an undecided finding, what it may be.
        certainty: How surely it is this, what it might be instead, and what would decide.
        torque_rms: Root mean square of its torque on each joint.
        held_out: By how much it lowers twice the negative log likelihood of runs held out.
        size: Its torque with an interval; older files lack it.
        left_out: Parameters that the data do not determine, which are not shown -> why.
        family: Name of the narrowest family that is certain; empty where none is, and in older files.
        family_probability: That it is any member of that family.
    """

    effect: EffectName
    joints: Joints
    sentence: str
    probability: Probability
    parameters: dict[str, QuantityRow]
    alternatives: tuple[AlternativeRow, ...]
    torque_rms: SizeByJoint
    held_out: NumberOrNull
    name: str = ""
    headline: str = ""
    certainty: str = ""
    size: SizeTable | None = None
    left_out: dict[str, str] = {}
    family: str = ""
    family_probability: Probability | None = None

    @property
    def places(self) -> list[int]:
        """Its joints, from 0."""
        return [joint - 1 for joint in self.joints]


class RemainderRow(Struct, frozen=True):
    """What no finding accounts for; older files give it over noise only."""

    joint: JointNumber
    over_noise: SizeOrNull
    probability: Probability
    depends_on: str
    left: str | None = None


class MomentRow(Struct, frozen=True):
    """When a run differs from the model as at no other time."""

    run: str
    start: NumberOrNull
    end: NumberOrNull
    joints: Annotated[Joints, Meta(min_length=1)]
    direction: tuple[NumberOrNull, NumberOrNull, NumberOrNull]
    force: SizeOrNull


class ChangeRow(Struct, frozen=True):
    """What a candidate alone would change."""

    effect: EffectName
    joints: Joints
    joint: JointNumber
    squared_error_percent: NumberOrNull
    std_percent: SizeOrNull
    gain: NumberOrNull
    name: str = ""


class ShareRow(Struct, frozen=True):
    """A part of the misfit; `finding` is the place of a finding, undecided ones behind the others."""

    name: str
    effect: str
    joints: Joints
    finding: Count | None
    percent: tuple[Percent | None, ...]


class BudgetTable(Struct, frozen=True):
    """Where the misfit goes.

    Attributes:
        before_rms: Residual of the model fitted within its tolerances, without any finding.
        after_rms: With all findings.
        shares: What explains how much of the square of `before_rms`; they add up to 100 % on every joint.
        held_out: Runs that it is of; none where each block of the fitted runs is predicted by the others.
        noise_measured_at_rest: Whether sensor noise was measured.
    """

    units: tuple[Unit, ...]
    before_rms: SizeByJoint
    after_rms: SizeByJoint
    shares: tuple[ShareRow, ...]
    held_out: tuple[str, ...]
    noise_measured_at_rest: bool


class SimulatedTable(Struct, frozen=True):
    """How simulations before and after agree with a recording."""

    run: str
    torque_rms_before: tuple[Finite | None, ...]
    torque_rms_after: tuple[Finite | None, ...]
    left_out: tuple[str, ...]


class DiagnosisFile(Struct, frozen=True, kw_only=True):
    """A diagnosis; keys with a default are missing in older files, which call the warnings `doubts`.

    Attributes:
        suspicions: Mistakes that the input may have instead of missing physics.
        noise: Noise floor of each joint's torque behind the filter; None without runs held out.
        torque_rms_before: Residual of runs held out by nominal values, friction and offsets fitted.
        torque_rms_after: With all findings; equal to the budget's.
        located: The misfit of every joint by what it depends on.
        hints: What runs held out show and fitted ones do not.
    """

    name: str
    joints: tuple[str, ...]
    unexplained: bool = False
    torque_units: tuple[Unit, ...] | None = None
    budget: BudgetTable | None = None
    verdict: tuple[str, ...]
    findings: tuple[FindingRow, ...]
    undecided: tuple[FindingRow, ...] = ()
    remainders: tuple[RemainderRow, ...]
    moments: tuple[MomentRow, ...] = ()
    changes: tuple[ChangeRow, ...] = ()
    noise: tuple[Positive | None, ...] | None
    noise_measured_at_rest: bool = True
    torque_rms_before: SizeByJoint | None = None
    torque_rms_after: SizeByJoint | None = None
    torque_rms_filter_hz: Size | None = None
    held_out: tuple[str, ...] | None = None
    runs: tuple[str, ...]
    located: tuple[Located, ...] = ()
    hints: tuple[Hinted, ...] = ()
    suspicions: tuple[str, ...] = ()
    warnings: tuple[str, ...] | None = None
    doubts: tuple[str, ...] | None = None
    seconds: Number
    simulated: SimulatedTable | None = None

    @property
    def units(self) -> tuple[str, ...]:
        """Of each joint's torque; older files are of revolute joints."""
        return self.torque_units or ("N m",) * len(self.joints)

    @property
    def every(self) -> tuple[FindingRow, ...]:
        """Findings, undecided ones last."""
        return (*self.findings, *self.undecided)

    @property
    def limits(self) -> tuple[str, ...]:
        """What limits the result, in sentences."""
        return self.warnings or self.doubts or ()

    def __post_init__(self) -> None:
        check(len(self.joints) > 0, "joints", (), "the names of the joints")
        check_different(self.joints, "joints")
        check(self.warnings is not None or self.doubts is not None, "warnings", None, "a list of sentences")
        for key in ("findings", "undecided"):
            for place, one in enumerate(getattr(self, key)):
                self._check_finding(one, f"{key}[{place}]")
        self._check_numbers_of_joints()
        self._by_joint(self.torque_units, "torque_units")
        if self.noise:
            for name in ("torque_rms_before", "torque_rms_after", "torque_rms_filter_hz", "held_out"):
                check(getattr(self, name) is not None, name, None, "a value beside noise")
        self._by_joint(self.noise or None, "noise")
        for name in ("torque_rms_before", "torque_rms_after"):
            self._by_joint(getattr(self, name), name)
        if self.simulated is not None:
            self._by_joint(self.simulated.torque_rms_before, "simulated.torque_rms_before")
            self._by_joint(self.simulated.torque_rms_after, "simulated.torque_rms_after")
        if self.budget is not None:
            self._check_budget(self.budget)

    def _by_joint(self, values: Sequence[object] | None, field: str) -> None:
        check_length(values, field, len(self.joints), "one a joint")

    def _check_finding(self, one: FindingRow, where: str) -> None:
        check_joints(one.joints, f"{where}.joints", len(self.joints))
        self._by_joint(one.torque_rms, f"{where}.torque_rms")
        if one.size is not None:
            check_joints([one.size.joint], f"{where}.size.joint", len(self.joints))
        for place, other in enumerate(one.alternatives):
            check_joints(other.joints, f"{where}.alternatives[{place}].joints", len(self.joints))

    def _check_numbers_of_joints(self) -> None:
        count = len(self.joints)
        for place, left in enumerate(self.remainders):
            check_joints([left.joint], f"remainders[{place}].joint", count)
        for place, moment in enumerate(self.moments):
            check_joints(moment.joints, f"moments[{place}].joints", count)
        for place, change in enumerate(self.changes):
            check_joints(change.joints, f"changes[{place}].joints", count)
            check_joints([change.joint], f"changes[{place}].joint", count)
        for key in ("located", "hints"):
            for place, row in enumerate(getattr(self, key)):
                check_joints([row.joint], f"{key}[{place}].joint", count)

    def _check_budget(self, budget: BudgetTable) -> None:
        for name in ("units", "before_rms", "after_rms"):
            self._by_joint(getattr(budget, name), f"budget.{name}")
        findings = len(self.findings) + len(self.undecided)
        check(bool(budget.shares), "budget.shares", [], "at least one part")
        for place, one in enumerate(budget.shares):
            where = f"budget.shares[{place}]"
            check_joints(one.joints, f"{where}.joints", len(self.joints))
            self._by_joint(one.percent, f"{where}.percent")
            known = one.finding is None or one.finding < findings
            check(known, f"{where}.finding", one.finding, f"the place of one of {findings} findings, from 0")
