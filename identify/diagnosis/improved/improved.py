"""Improved: the arm with what was found in it, and models of what that might be instead."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...effects import Effect, Prior
from ...model import Model
from ...simulation.plant import Transmission
from ..candidates import kind_of
from ..findings.arm import Arm
from ..findings.finding import Alternative, Diagnosis, Finding, Quantity
from ..findings.trace import Evidence


def as_nominal(evidence: Evidence) -> Arm:
    """The arm at its model's word, with friction and offsets as fitted."""
    model = evidence.model
    return Arm(model, evidence.before, evidence.gain_before, Transmission.rigid(model.robot.dof))


def as_found(evidence: Evidence, findings: Sequence[Finding]) -> Arm:
    """The arm with all that was found, its parameters fitted within their tolerances beside it."""
    model = evidence.model
    arm = Arm(model, evidence.after, evidence.gain_after, Transmission.rigid(model.robot.dof))
    for place, finding in enumerate(findings):
        more = with_finding(arm, finding)
        arm = replace(arm, left_out=(*arm.left_out, place)) if more is None else more
    return arm


def with_finding(arm: Arm, finding: Finding) -> Arm | None:
    """The arm with one finding; None where neither model nor transmission can hold it."""
    held = kind_of(finding.effect).held
    if held is not None:
        return held(arm, finding)
    if finding.candidate.instance is not None:
        return _plus(arm, finding.candidate.instance, finding)
    return None


def _plus(arm: Arm, effect: Effect, finding: Finding) -> Arm | None:
    """With one more effect, or with more of one that is there already."""
    names = [parameter.name for parameter in effect.parameters(arm.model.robot)]
    determined_as = kind_of(finding.effect).determined_as  # of a finding that is in words already
    reported = {name: name if name in finding.parameters else determined_as[name][0] for name in names}
    return arm.with_effect(effect, {name: finding.parameters[reported[name]].value for name in names})


FOUND = "found.toml"
"""File of the model with all findings."""


class Rival(NamedTuple):
    """A model with one finding replaced by what it might be instead."""

    finding: int  # its place, undecided ones behind the others
    alternative: int  # its place among the alternatives of that finding
    file: str  # under which it is written
    model: Model  # with what it might be, and its values; without either where a model cannot hold it
    left_out: tuple[str, ...]  # what no model holds, by name in the vocabulary


class Improved(NamedTuple):
    """A model with findings."""

    model: Model  # with the values found
    left_out: tuple[int, ...]  # places of findings that it does not hold


def found_model(diagnosis: Diagnosis) -> Model | None:
    """The model with all findings that a model can hold; None for a diagnosis without evidence.

    Undecided ones are in it by the name under which they were fitted.
    """
    return None if diagnosis.evidence is None else _model(diagnosis.evidence, _every(diagnosis)).model


def left_out(diagnosis: Diagnosis) -> tuple[str, ...]:
    """What the model with all findings does not hold, by name in the vocabulary."""
    if diagnosis.evidence is None:
        return ()
    every = _every(diagnosis)
    return tuple(every[place].effect for place in _model(diagnosis.evidence, every).left_out)


def rivals(diagnosis: Diagnosis) -> list[Rival]:
    """One for each alternative, but where neither it nor the finding is anything that a model can hold."""
    if diagnosis.evidence is None:
        return []
    every, found = _every(diagnosis), list[Rival]()
    lost = _model(diagnosis.evidence, every).left_out
    for place, finding in enumerate(every):
        for other, alternative in enumerate(finding.alternatives):
            instead = list(every)
            instead[place] = as_finding(alternative)
            improved = _model(diagnosis.evidence, instead)
            if place in lost and place in improved.left_out:
                continue
            absent = tuple(instead[lacking].effect for lacking in improved.left_out)
            file = f"instead-{len(found) + 1}.toml"
            found.append(Rival(place, other, file, improved.model, absent))
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


def _model(evidence: Evidence, findings: Sequence[Finding]) -> Improved:
    """A model has rigid gears: play and elasticity are no part of it, and neither is what a sensor does."""
    soft = [place for place, one in enumerate(findings) if kind_of(one.effect).gear]
    rigid = [place for place in range(len(findings)) if place not in soft]
    arm = as_found(evidence, [findings[place] for place in rigid])
    lost = sorted([*soft, *(rigid[place] for place in arm.left_out)])
    return Improved(model_of(arm), tuple(lost))


def model_of(arm: Arm) -> Model:
    """The arm's model with its values and gains as nominal ones, and the deviations of before."""
    std = [prior.std for prior in arm.model.priors]
    stated = {
        name: Prior(value, deviation)
        for (name, value), deviation in zip(arm.by_name.items(), std, strict=True)
    }
    return replace(arm.model, robot=replace(arm.model.robot, drive_gain=arm.gain), stated=stated)
