"""Improved: the arm with its findings, and models with alternatives instead."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from ...errors import RobotError
from ...model import Model
from ..candidates import kind_of
from ..findings.arm import Arm
from ..findings.diagnosis import Diagnosis
from ..findings.evidence import Evidence
from ..findings.finding import Hypothesis

FOUND = "found.toml"
"""Name of the file with all findings."""


def as_nominal(known: Evidence) -> Arm:
    """The arm without findings, its parameters fitted within their tolerances."""
    return Arm(known.model, known.before, known.gain_before, peak=known.peak)


def as_found(known: Evidence, findings: Sequence[Hypothesis]) -> Arm:
    """The arm with findings, its other parameters fitted within their tolerances."""
    arm = Arm(known.model, known.after, known.gain_after, peak=known.peak)
    for place, finding in enumerate(findings):
        more = with_finding(arm, finding)
        arm = replace(arm, left_out=(*arm.left_out, place)) if more is None else more
    return arm


def with_finding(arm: Arm, finding: Hypothesis) -> Arm | None:
    """The arm with one more finding; None if no model can hold it."""
    kind, effect = kind_of(finding.effect), finding.term
    if kind.held is not None:
        try:
            return kind.held(arm, finding)
        except RobotError:  # the numbers of an alternative may be physically impossible
            return None
    if effect is None:
        return None
    names = [parameter.name for parameter in effect.parameters(arm.model.robot)]
    determined_as = kind.determined_as  # the finding may have its reported names already
    reported = {name: name if name in finding.parameters else determined_as[name][0] for name in names}
    return arm.with_effect(effect, {name: finding.parameters[reported[name]].value for name in names})


class Rival(NamedTuple):
    """A model in which an alternative replaces one finding."""

    finding: int  # index of the finding, undecided ones behind the others
    alternative: int  # index among the alternatives of that finding
    file: str  # name of its file
    model: Model  # with the alternative and its values, if a model can hold it
    held: bool  # whether the model has the alternative


def found_model(diagnosis: Diagnosis) -> Model | None:
    """The model with all findings that a model can hold; None for a diagnosis without evidence.

    Undecided findings are included as the hypothesis that was fitted.
    """
    return None if diagnosis.evidence is None else _model(diagnosis.evidence, diagnosis.all_findings)[0]


def left_out(diagnosis: Diagnosis) -> tuple[int, ...]:
    """Indices of the findings that no model can hold, undecided ones behind the others."""
    return () if diagnosis.evidence is None else _model(diagnosis.evidence, diagnosis.all_findings)[1]


def rivals(diagnosis: Diagnosis) -> list[Rival]:
    """For each finding, its likeliest alternative, unless a model can hold neither it nor the finding."""
    if diagnosis.evidence is None:
        return []
    findings, models = diagnosis.all_findings, list[Rival]()
    lost = left_out(diagnosis)
    for place, finding in enumerate(findings):
        for index, other in enumerate(finding.alternatives):
            instead = [*findings[:place], other, *findings[place + 1 :]]
            model, lacking = _model(diagnosis.evidence, instead)
            if place not in lost or place not in lacking:
                file = f"instead-{len(models) + 1}.toml"
                models.append(Rival(place, index, file, model, place not in lacking))
                break
    return models


def _model(evidence: Evidence, findings: Sequence[Hypothesis]) -> tuple[Model, tuple[int, ...]]:
    """The nominal model with findings at their values, and the indices of findings that it does not hold."""
    arm = as_found(evidence, findings)
    robot = replace(arm.model.robot, drive_gain=arm.gain)
    return replace(arm.model.at(arm.values), robot=robot), arm.left_out


def with_files(diagnosis: Diagnosis) -> Diagnosis:
    """The diagnosis with the file name of each rival."""
    findings, named = list(diagnosis.all_findings), len(diagnosis.findings)
    for rival in rivals(diagnosis):
        others = list(findings[rival.finding].alternatives)
        others[rival.alternative] = replace(others[rival.alternative], file=rival.file)
        findings[rival.finding] = replace(findings[rival.finding], alternatives=tuple(others))
    return replace(diagnosis, findings=tuple(findings[:named]), undecided=tuple(findings[named:]))
