"""Rivals: models of what was found and of what it might be instead, for a run that tells them apart."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..effects import Belief
from ..model import Model
from .finding import Alternative, Diagnosis, Finding, Quantity
from .improved import Arm, as_found
from .trace import Evidence

FOUND = "found.toml"
"""File of the model with all findings."""


class Rival(NamedTuple):
    """A model with one finding replaced by what it might be instead.

    Attributes:
        finding: Place of the finding.
        alternative: Its place among the alternatives of that finding.
        file: Under which it is written.
        model: With what it might be, and its values.
    """

    finding: int
    alternative: int
    file: str
    model: Model


def found_model(diagnosis: Diagnosis) -> Model | None:
    """The model with all findings, and their values as beliefs; None where no model can hold them."""
    return None if diagnosis.evidence is None else _model(diagnosis.evidence, diagnosis.findings)


def rivals(diagnosis: Diagnosis) -> list[Rival]:
    """One for each alternative that a model can hold, if what was found is a model too."""
    if diagnosis.evidence is None or found_model(diagnosis) is None:
        return []
    found: list[Rival] = []
    for place, finding in enumerate(diagnosis.findings):
        for other, alternative in enumerate(finding.alternatives):
            instead = list(diagnosis.findings)
            instead[place] = as_finding(alternative)
            if (model := _model(diagnosis.evidence, instead)) is not None:
                found.append(Rival(place, other, f"instead-{len(found) + 1}.toml", model))
    return found


def as_finding(alternative: Alternative) -> Finding:
    """The alternative as if it had been found."""
    hypothesis = alternative.hypothesis
    assert hypothesis is not None
    candidate = hypothesis.candidate
    parameters = {
        name: Quantity(float(value), np.nan, unit)
        for name, value, unit in zip(candidate.names, hypothesis.values, candidate.units, strict=True)
    }
    shape = {name: Quantity(value, np.nan, "") for name, value in candidate.shape.items()}
    return Finding(
        effect=alternative.effect,
        joints=alternative.joints,
        parameters=shape | parameters,
        probability=alternative.probability,
        alternatives=(),
        torque=np.zeros(len(hypothesis.columns.joints)),
        held_out=np.nan,
        candidate=candidate,
    )


def _model(evidence: Evidence, findings: Sequence[Finding]) -> Model | None:
    arm = as_found(evidence, findings)
    return None if arm.left_out or len(arm.transmission.elastic) else believing(arm)


def believing(arm: Arm) -> Model:
    """The arm's model, in which its values and gains are what is believed, with the deviations of before."""
    std = [belief.std for belief in arm.model.beliefs]
    stated = {
        name: Belief(value, deviation)
        for (name, value), deviation in zip(arm.by_name.items(), std, strict=True)
    }
    return replace(arm.model, robot=replace(arm.model.robot, drive_gain=arm.gain), stated=stated)
