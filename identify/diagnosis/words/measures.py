"""Measures: units by a joint's kind; effects state theirs for revolute joints."""

from dataclasses import replace

import numpy as np

from ...arm.robot import SLIDING as LINEAR
from ..candidates import kind_of
from ..findings.finding import Diagnosis, Finding
from ..findings.quantities import SLIDING, TURNING
from ..results.budget import NOISE


def revolute(diagnosis: Diagnosis) -> np.ndarray:
    """Whether each joint is revolute, shape (n,); all are unless known otherwise."""
    if diagnosis.evidence is None:
        return np.ones(len(diagnosis.joints), bool)
    return np.asarray(diagnosis.evidence.model.robot.revolute, bool)


def torque_units(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Unit of each joint's torque, or force."""
    return tuple(TURNING if one else SLIDING for one in revolute(diagnosis))


def in_unit(unit: str, revolute: bool) -> str:
    """A unit that is stated for a revolute joint, for a revolute or a prismatic one."""
    return unit if revolute else LINEAR.get(unit, unit)


def by_kind(diagnosis: Diagnosis) -> Diagnosis:
    """The diagnosis with its parameters in the units of their joints; the same if that is done already."""
    return replace(
        diagnosis,
        findings=tuple(_stated(diagnosis, one) for one in diagnosis.findings),
        undecided=tuple(_stated(diagnosis, one) for one in diagnosis.undecided),
    )


def slides(diagnosis: Diagnosis, finding: Finding) -> bool:
    """Whether a finding is stated in the units of joints that slide."""
    on = list(finding.joints)
    return not kind_of(finding.effect).of_body and bool(on) and not np.any(revolute(diagnosis)[on])


def _stated(diagnosis: Diagnosis, finding: Finding) -> Finding:
    determined_as = kind_of(finding.effect).determined_as
    pairs = [(*determined_as.get(name, (name, one.unit)), one) for name, one in finding.parameters.items()]
    turning = not slides(diagnosis, finding)
    parameters = {name: one._replace(unit=in_unit(unit, turning)) for name, unit, one in pairs if name}
    left_out = {determined_as.get(name, (name, ""))[0]: one for name, one in finding.left_out.items()}
    return replace(finding, parameters=parameters, left_out=left_out)


def noise_measured(diagnosis: Diagnosis) -> bool:
    """Whether sensor noise was measured at rest, so that other numbers may be given as multiples of it.

    A budget has a share of noise only then; else it is part of what depends on nothing that was recorded.
    """
    if diagnosis.budget is None:
        return False
    return any(one.kind == NOISE and bool(np.any(one.shares > 0.0)) for one in diagnosis.budget.shares)
