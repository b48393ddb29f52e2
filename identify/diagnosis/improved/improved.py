"""Improved: the arm with what was found in it, and models of what that might be instead."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...errors import RobotError
from ...model import Model
from ..candidates import kind_of
from ..findings.arm import Arm
from ..findings.finding import Alternative, Diagnosis, Evidence, Finding, Quantity

FOUND = "found.toml"
"""File of the model with all findings."""


def as_nominal(known: Evidence) -> Arm:
    """The nominal arm, with friction and offsets as fitted."""
    return Arm(known.model, known.before, known.gain_before, peak=known.peak)


def as_found(known: Evidence, findings: Sequence[Finding]) -> Arm:
    """The arm with all that was found, its parameters fitted within their tolerances beside it."""
    arm = Arm(known.model, known.after, known.gain_after, peak=known.peak)
    for place, finding in enumerate(findings):
        more = with_finding(arm, finding)
        arm = replace(arm, left_out=(*arm.left_out, place)) if more is None else more
    return arm


def with_finding(arm: Arm, finding: Finding) -> Arm | None:
    """The arm with one finding; None where no model can hold it."""
    kind, effect = kind_of(finding.effect), finding.candidate.instance
    if kind.held is not None:
        try:
            return kind.held(arm, finding)
        except RobotError:  # numbers that no arm has, as those of an alternative may be
            return None
    if effect is None:
        return None
    names = [parameter.name for parameter in effect.parameters(arm.model.robot)]
    determined_as = kind.determined_as  # of a finding that is in words already
    reported = {name: name if name in finding.parameters else determined_as[name][0] for name in names}
    return arm.with_effect(effect, {name: finding.parameters[reported[name]].value for name in names})


class Rival(NamedTuple):
    """A model with one finding replaced by what it might be instead."""

    finding: int  # its place, undecided ones behind the others
    alternative: int  # its place among the alternatives of that finding
    file: str  # under which it is written
    model: Model  # with what it might be, and its values; without either where a model cannot hold it
    left_out: tuple[str, ...]  # what no model holds, by name in the vocabulary


def found_model(diagnosis: Diagnosis) -> Model | None:
    """The model with all findings that a model can hold; None for a diagnosis without evidence.

    Undecided ones are in it by the name under which they were fitted.
    """
    return None if diagnosis.evidence is None else _model(diagnosis.evidence, _every(diagnosis))[0]


def left_out(diagnosis: Diagnosis) -> tuple[str, ...]:
    """What the model with all findings does not hold, by name in the vocabulary."""
    if diagnosis.evidence is None:
        return ()
    every = _every(diagnosis)
    return tuple(every[place].effect for place in _model(diagnosis.evidence, every)[1])


def rivals(diagnosis: Diagnosis) -> list[Rival]:
    """One for each alternative, but where neither it nor the finding is anything that a model can hold."""
    if diagnosis.evidence is None:
        return []
    every, found = _every(diagnosis), list[Rival]()
    lost = _model(diagnosis.evidence, every)[1]
    for place, finding in enumerate(every):
        for other, alternative in enumerate(finding.alternatives):
            instead = list(every)
            instead[place] = as_finding(alternative)
            model, lacking = _model(diagnosis.evidence, instead)
            if place in lost and place in lacking:
                continue
            absent = tuple(instead[one].effect for one in lacking)
            found.append(Rival(place, other, f"instead-{len(found) + 1}.toml", model, absent))
    return found


def _every(diagnosis: Diagnosis) -> tuple[Finding, ...]:
    return (*diagnosis.findings, *diagnosis.undecided)


def as_finding(alternative: Alternative) -> Finding:
    """The alternative as if it had been found."""
    answer = alternative.answer
    assert answer is not None
    candidate = answer.candidate
    parameters = {
        name: Quantity(float(value), np.nan, unit)
        for name, value, unit in zip(candidate.names, answer.values, candidate.units, strict=True)
    }
    shape = {name: Quantity(value, np.nan, "") for name, value in candidate.shape.items()}
    return Finding(
        effect=alternative.effect,
        joints=alternative.joints,
        parameters=shape | parameters,
        probability=alternative.probability,
        alternatives=(),
        torque=np.zeros(len(answer.columns.joints)),
        held_out=np.nan,
        candidate=candidate,
    )


def _model(evidence: Evidence, findings: Sequence[Finding]) -> tuple[Model, tuple[int, ...]]:
    """The nominal model with findings at their values, and the places of those that it does not hold."""
    arm = as_found(evidence, findings)
    robot = replace(arm.model.robot, drive_gain=arm.gain)
    return replace(arm.model.at(arm.values), robot=robot), arm.left_out
