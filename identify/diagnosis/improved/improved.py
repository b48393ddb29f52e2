"""Improved: the arm with what was found in it, as far as a model can hold it."""

from collections.abc import Sequence
from dataclasses import replace

from ...effects import Effect
from ...simulation.plant import Transmission
from ..candidates import kind_of
from ..findings.arm import Arm
from ..findings.finding import Finding
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
