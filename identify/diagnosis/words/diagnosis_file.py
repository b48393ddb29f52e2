"""diagnosis.json: all of a diagnosis but its samples; every page is made from it."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from msgspec import json

from ..findings.axes import AXES
from ..findings.finding import Alternative, Change, Diagnosis, Finding, Moment, Quantity, Remainder, Share
from ..findings.size import Size
from ..improved.forward import Forward
from ..results.budget import NOISE, OTHER
from .diagnosis_schema import (
    AlternativeRow,
    BudgetTable,
    ChangeRow,
    DiagnosisFile,
    FindingRow,
    MomentRow,
    QuantityRow,
    RemainderRow,
    ShareRow,
    SimulatedTable,
)
from .measures import by_kind, noise_measured, torque_units
from .naming import distinct, effect_words, named
from .sentences import possible, undecided_sentence
from .size_schema import PointRow, SizeRow, SizeTable
from .size_words import left_out_words, rows_head, size_rows, size_words, unit_over
from .verdict import certainty, headline, left_on, sized, undecided, verdict

UNDECIDED = " (name undecided)"


def as_json(file: DiagnosisFile) -> dict[str, Any]:
    """What is written."""
    table = {"exidyn_diagnosis": 1} | json.decode(json.encode(file))
    return {
        key: value for key, value in table.items() if value is not None or key not in ("doubts", "simulated")
    }


def number(value: float) -> float | None:
    """A number that JSON has; NaN and infinity are none."""
    return float(value) if np.isfinite(value) else None


def numbers(values: Iterable[float]) -> tuple[float | None, ...]:
    """Each of them."""
    return tuple(map(number, values))


def value_of(number: float | None) -> float:
    """A number out of a file; null is NaN."""
    return float("nan") if number is None else float(number)


def array_of(values: Sequence[float | None] | None) -> np.ndarray:
    """Numbers out of a file; what is null is NaN."""
    return np.array(values or (), float)


def answer(diagnosis: Diagnosis) -> dict[str, Any]:
    """One case of an answer file, in the words of the vocabulary; joints count from 1.

    What is undecided is answered with the most probable name, and its confidence shows it; a curve without a
    formula with the most probable formula that it might be.
    """
    every = (*diagnosis.findings, *diagnosis.undecided)
    gained = diagnosis.improvement
    residuals = gained and {
        "torque_rms_before": list(numbers(gained.before)),
        "torque_rms_after": list(numbers(gained.after)),
        "torque_rms_filter_hz": gained.band,
    }
    return {
        "findings": [answered for answered in map(_answered, every) if answered],
        "unexplained": diagnosis.unexplained,
        **(residuals or {}),
        "seconds": round(diagnosis.seconds, 2),
    }


def _answered(finding: Finding) -> dict[str, Any]:
    """The most probable name that the vocabulary has, if any, and the family where one is certain."""
    names = [one for one in possible(finding) if one.listed]
    if not names:
        return {}
    first, *rest = names
    family = {"family": finding.family, "family_confidence": finding.family_probability}
    stated = finding.determined if first is finding else {}
    return {
        **_place(first),
        "confidence": first.probability,
        "alternatives": [_place(one) for one in rest],
        **(family if finding.family else {}),
        "parameters": {name: list(numbers(one[:2])) for name, one in stated.items()},
    }


def _place(one: Finding | Alternative) -> dict[str, Any]:
    return {"effect": one.effect, "joints": list(_joints(one.joints))}


def _joints(joints: Sequence[int]) -> tuple[int, ...]:
    """As people count them."""
    return tuple(joint + 1 for joint in joints)


def diagnosis_file(diagnosis: Diagnosis, forward: Forward | None = None, folder: str = "") -> DiagnosisFile:
    """All of a diagnosis but its samples.

    Args:
        diagnosis: What was found.
        forward: How simulations of a run compare with it; None if there are none.
        folder: Where models of findings and rivals are written; empty if they are not.
    """
    diagnosis = by_kind(diagnosis)
    gained = diagnosis.improvement
    return DiagnosisFile(
        name=diagnosis.name,
        joints=diagnosis.joints,
        unexplained=diagnosis.unexplained,
        torque_units=torque_units(diagnosis),  # type: ignore[arg-type]
        budget=_budget(diagnosis),
        verdict=tuple(verdict(diagnosis, folder)),
        findings=tuple(_finding(diagnosis, place, folder) for place in range(len(diagnosis.findings))),
        undecided=tuple(_undecided(diagnosis, place, folder) for place in range(len(diagnosis.undecided))),
        remainders=tuple(_remainder(one, diagnosis) for one in diagnosis.remainders),
        moments=tuple(map(_moment, diagnosis.moments)),
        changes=_changes(diagnosis.changes, diagnosis.joints),
        noise=None if gained is None else numbers(gained.noise),
        noise_measured_at_rest=noise_measured(diagnosis),
        torque_rms_before=None if gained is None else numbers(gained.before),
        torque_rms_after=None if gained is None else numbers(gained.after),
        torque_rms_filter_hz=None if gained is None else gained.band,
        runs=diagnosis.runs,
        held_out=() if gained is None else gained.runs,
        located=tuple(replace(one, joint=one.joint + 1) for one in diagnosis.located),
        hints=tuple(replace(one, joint=one.joint + 1) for one in diagnosis.hints),
        suspicions=diagnosis.suspicions,
        warnings=diagnosis.warnings,
        seconds=round(diagnosis.seconds, 2),
        simulated=None if forward is None else _simulated(forward),
    )


def _simulated(forward: Forward) -> SimulatedTable:
    """A simulation that diverges has no numbers."""
    return SimulatedTable(
        run=forward.run,
        torque_rms_before=numbers(forward.before),
        torque_rms_after=numbers(forward.after),
        left_out=forward.left_out,
    )


def _finding(diagnosis: Diagnosis, place: int, folder: str) -> FindingRow:
    finding = diagnosis.findings[place]
    said = sized(diagnosis, finding)
    return _row(diagnosis, finding, said, headline(diagnosis, finding), certainty(diagnosis, place, folder))


def _undecided(diagnosis: Diagnosis, place: int, folder: str) -> FindingRow:
    finding = diagnosis.undecided[place]
    said = undecided_sentence(finding, diagnosis.joints).removesuffix(".")
    return _row(diagnosis, finding, said, undecided(diagnosis, place, folder), "")


def _row(diagnosis: Diagnosis, finding: Finding, said: str, headline: str, certainty: str) -> FindingRow:
    every = (*diagnosis.findings, *diagnosis.undecided)
    return FindingRow(
        effect=finding.effect,
        joints=_joints(finding.joints),
        sentence=said,
        probability=finding.probability,
        parameters={name: _quantity(one) for name, one in finding.parameters.items()},
        alternatives=tuple(
            AlternativeRow(one.effect, _joints(one.joints), number(one.probability))
            for one in finding.alternatives
        ),
        torque_rms=numbers(finding.torque),
        held_out=number(finding.held_out),
        name=_names(every, diagnosis.joints)[every.index(finding)],
        headline=headline,
        certainty=certainty,
        size=None if finding.size is None else _size(finding.size, diagnosis),
        left_out=left_out_words(finding.left_out),
        family=finding.family,
        family_probability=number(finding.family_probability),
    )


def _size(size: Size, diagnosis: Diagnosis) -> SizeTable:
    axis = AXES.get(size.over)
    return SizeTable(
        joint=size.joint + 1,
        unit=torque_units(diagnosis)[size.joint],  # type: ignore[arg-type]
        sentence=size_words(size, diagnosis),
        head=rows_head(size, diagnosis),
        rows=tuple(SizeRow(*row) for row in size_rows(size, diagnosis)),
        beside_rms=number(size.beside[0]),
        beside_std=number(size.beside[1]),
        over=axis.words if axis else "",
        over_unit=unit_over(size, diagnosis),
        braking=axis is not None and axis.braking,
        change=size.change,
        points=tuple(PointRow(one.at, one.torque, one.std, one.which) for one in size.points),
        curve=tuple(PointRow(one.at, one.torque, one.std) for one in size.curve),
    )


def _quantity(one: Quantity) -> QuantityRow:
    return QuantityRow(number(one.value), number(one.std), one.unit)


def _names(every: Sequence[Finding], joints: Sequence[str]) -> list[str]:
    """Effects and where they act, each with its shape where two are the same."""
    names = [named(one.effect, one.joints, joints) for one in every]
    return distinct(names, [one.candidate.which for one in every])


def _remainder(one: Remainder, diagnosis: Diagnosis) -> RemainderRow:
    return RemainderRow(
        one.joint + 1, number(one.over_noise), one.probability, one.depends_on, left_on(one, diagnosis)
    )


def _moment(one: Moment) -> MomentRow:
    return MomentRow(
        one.run,
        number(one.start),
        number(one.end),
        _joints(one.joints),
        numbers(one.direction),  # type: ignore[arg-type]
        number(one.force),
    )


def _changes(changes: Sequence[Change], joints: Sequence[str]) -> tuple[ChangeRow, ...]:
    names = distinct(
        [named(one.effect, one.joints, joints) for one in changes], [one.which for one in changes]
    )
    return tuple(
        ChangeRow(
            one.effect,
            _joints(one.joints),
            one.joint + 1,
            number(100.0 * one.change),
            number(100.0 * one.std),
            number(one.gain),
            name,
        )
        for one, name in zip(changes, names, strict=True)
    )


def _budget(diagnosis: Diagnosis) -> BudgetTable | None:
    """Where the misfit goes, with names; findings as they are, kinds by size, noise and the rest last."""
    budget, gained = diagnosis.budget, diagnosis.improvement
    if budget is None:
        return None
    measured = noise_measured(diagnosis)
    shares = [_share(one, diagnosis) for one in budget.shares if measured or one.kind != NOISE]
    return BudgetTable(
        units=torque_units(diagnosis),  # type: ignore[arg-type]
        before_rms=numbers(budget.before),
        after_rms=numbers(budget.after),
        shares=tuple(sorted(shares, key=_order)),
        held_out=gained.runs if gained and budget.held_out else (),
        noise_measured_at_rest=measured,
    )


def _share(share: Share, diagnosis: Diagnosis) -> ShareRow:
    percent = numbers(100.0 * share.shares)
    if share.finding is None:
        kind = share.kind if share.kind in (NOISE, OTHER) else f"depends on {share.kind}"
        return ShareRow(kind, "", (), None, percent)
    every = (*diagnosis.findings, *diagnosis.undecided)
    finding, open_ = every[share.finding], share.finding >= len(diagnosis.findings)
    shown = possible(finding)[0] if open_ else finding
    fitted = shown is finding
    name = (
        _names(every, diagnosis.joints)[share.finding]
        if fitted
        else named(shown.effect, shown.joints, diagnosis.joints)
    )
    mark = UNDECIDED if open_ else ""
    return ShareRow(
        name + mark, effect_words(shown.effect) + mark, _joints(shown.joints), share.finding, percent
    )


def _order(share: ShareRow) -> tuple[int, float]:
    if share.finding is not None:
        return 0, float(share.finding)
    return {NOISE: 2, OTHER: 3}.get(share.name, 1), -float(np.nanmax(array_of(share.percent)))
