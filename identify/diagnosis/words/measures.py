"""Units of findings on revolute and prismatic joints, and their sizes in words.

Effects state their units for revolute joints.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from ...arm.robot import SLIDING as LINEAR
from ...arm.robot import Robot
from ...text_table import digits
from ..candidates import kind_of
from ..findings.axes import AXES
from ..findings.diagnosis import Diagnosis
from ..findings.finding import Finding
from ..findings.quantities import AMPERE, SLIDING, TURNING, with_interval
from ..findings.size import OF_A_CURVE, LeftOut, Size
from .naming import effect_words, joined

BESIDE = "other parameters can absorb all of its torque but {} (root mean square)"
TorqueUnit = Literal["N m", "N", "A"]


def torque_units(robot: Robot, measures: str) -> tuple[TorqueUnit, ...]:
    """Unit of each joint's torque or force; amperes on revolute joints if no drive gain is known."""
    turning = AMPERE if measures == "current" and np.all(robot.drive_gain == 1.0) else TURNING
    return tuple(turning if revolute else SLIDING for revolute in robot.revolute)


def revolute(diagnosis: Diagnosis, joint: int) -> bool:
    """Whether a joint is revolute."""
    return diagnosis.torque_units[joint] != SLIDING


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


def unit_over(size: Size, diagnosis: Diagnosis) -> str:
    """Unit of the quantity that the torque depends on; empty if there is none."""
    return AXES[size.over].unit(revolute(diagnosis, size.joint)) if size.over else ""


def size_words(size: Size, diagnosis: Diagnosis) -> str:
    """Torque of a finding as a part of a sentence: at its points, or else its root mean square."""
    unit = diagnosis.torque_units[size.joint]
    if not size.known:
        return BESIDE.format(f"{with_interval(size.beside_rms, size.beside_std)} {unit}")
    axis = AXES[size.over]
    against = " against the motion" if axis.braking else ""
    unit_at = unit_over(size, diagnosis)
    places = [f"{digits(point.at, 2)} {unit_at} ({point.which})" for point in size.points]
    torques = [f"{with_interval(point.torque, point.std)} {unit} at " for point in size.points]
    start = f"relative to that at a {axis.words} of {places[0]}" if size.change else f"over the {axis.words}"
    values = [torque + place for torque, place in zip(torques, places, strict=True)][size.change :]
    return f"{start}, its torque{against} is {joined(values)}"


def left_out_words(left_out: Mapping[str, LeftOut]) -> list[str]:
    """Why parameters are not given, a sentence for each reason; none for coefficients of a curve."""
    reasons = dict.fromkeys(reason for reason in left_out.values() if reason != OF_A_CURVE)
    names = [[name for name, other in left_out.items() if other == reason] for reason in reasons]
    return [
        f"{joined(parameters)} {'are' if parameters[1:] else 'is'} not given because {_why(reason)}."
        for parameters, reason in zip(names, reasons, strict=True)
    ]


def _why(reason: LeftOut) -> str:
    if not reason.beside:
        return "these runs do not determine all parameters together"
    of = f" of {effect_words(reason.effect)}" if reason.effect else ""
    return f"these runs cannot separate it from {reason.beside}{of}"
