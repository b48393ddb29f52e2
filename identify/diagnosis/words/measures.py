"""Units of findings on revolute and prismatic joints; effects state their units for revolute joints."""

from dataclasses import replace
from typing import Literal

import numpy as np

from ...arm.robot import SLIDING as LINEAR
from ...arm.robot import Robot
from ..candidates import kind_of
from ..findings.diagnosis import Diagnosis
from ..findings.finding import Finding
from ..findings.quantities import SLIDING, TURNING

TorqueUnit = Literal["N m", "N"]


def torque_units(robot: Robot) -> tuple[TorqueUnit, ...]:
    """Unit of each joint's torque or force."""
    return tuple(TURNING if turning else SLIDING for turning in robot.revolute)


def revolute(diagnosis: Diagnosis, joint: int) -> bool:
    """Whether a joint is revolute."""
    return diagnosis.torque_units[joint] == TURNING


def slides(diagnosis: Diagnosis, finding: Finding) -> bool:
    """Whether a finding has the units of prismatic joints."""
    turning = [revolute(diagnosis, joint) for joint in finding.joints]
    return not kind_of(finding.effect).of_body and bool(turning) and not any(turning)


def in_units_of_joints(finding: Finding, robot: Robot) -> Finding:
    """The finding with the parameters that the data determine, named and in the units of its joints."""
    kind, on = kind_of(finding.effect), list(finding.joints)
    turning = kind.of_body or not on or bool(np.any(robot.revolute[on]))
    parameters = {}
    for name, quantity in finding.parameters.items():
        reported, unit = kind.determined_as.get(name, (name, quantity.unit))
        if reported:
            parameters[reported] = replace(quantity, unit=unit if turning else LINEAR.get(unit, unit))
    reasons = finding.left_out.items()
    left_out = {kind.determined_as.get(name, (name, ""))[0]: reason for name, reason in reasons}
    return replace(finding, parameters=parameters, left_out=left_out)
