"""Gains of a file's position servos, where they are what was identified.

Of logs without current, what is left to the command stands for it, and a drive gain is a servo's kp. What the
servo damps by itself is then part of the viscous friction, so that its own damping becomes zero.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..arm.robot import Robot
from ..errors import RobotError
from ..robot_files.mjcf_drives import servos
from ..robot_files.mjcf_names import name_of
from ..text_table import NORMAL_95
from .mjcf_changes import DIGITS, SAME, Change, File, same
from .portable import Portable
from .xml_text import Edits


def servo_changes(file: File, portable: Portable, edits: Edits) -> Iterator[Change]:
    """Write the stiffness of all servos, where the robot's drives are such and the file has them too."""
    robot, found = portable.robot, servos(file.compiled, portable.robot.joints)
    if robot.servo is None or not found:
        return
    for place, (actuator, wanted) in enumerate(zip(found, stiffness(robot), strict=True)):
        where = f"actuator '{name_of(file.compiled, 'actuator', actuator)}'"
        old, damping = _gains(file.compiled, actuator)
        gear = float(file.compiled.actuator_gear[actuator][0])
        if same(old * gear**2, float(wanted)) and not damping:
            continue
        _write(file, actuator, float(wanted) / gear**2, edits)
        half = NORMAL_95 * float(robot.drive_gain_tolerance[place] * wanted) / gear**2
        yield Change(where, "kp", robot.unit(place, "N m/rad"), old, float(wanted) / gear**2, half)
        if damping:
            yield Change(where, "kv", robot.unit(place, "N m s/rad"), damping, 0.0, np.inf)


def require_servos(compiled: Any, portable: Portable, where: str) -> None:
    """Compare what MuJoCo makes of the new text with what was meant.

    Raises:
        RobotError: It makes something else.
    """
    robot, found = portable.robot, servos(compiled, portable.robot.joints)
    for actuator, wanted in zip(found, stiffness(robot) if robot.servo else (), strict=False):
        kp, damping = _gains(compiled, actuator)
        made = kp * float(compiled.actuator_gear[actuator][0]) ** 2
        if abs(made - wanted) > SAME * wanted or damping:
            raise RobotError(
                f"{where}: actuator '{name_of(compiled, 'actuator', actuator)}' has kp {made:.4g} and kv "
                f"{damping:.4g} in MuJoCo, not {wanted:.4g} and 0, whatever its element says"
            )


def stiffness(robot: Robot) -> np.ndarray:
    """Torque per error of each servo, shape (n,) [N m/rad]."""
    return np.ones(robot.dof) if robot.servo is None else np.abs(robot.drive_gain) * robot.servo.gain


def _gains(compiled: Any, actuator: int) -> tuple[float, float]:
    """Its kp and kv."""
    return float(compiled.actuator_gainprm[actuator][0]), -float(compiled.actuator_biasprm[actuator][2]) + 0.0


def _write(file: File, actuator: int, kp: float, edits: Edits) -> None:
    tag, number = file.elements.actuator(actuator), f"{kp:.{DIGITS}g}"
    if tag.name == "position":
        edits.set(tag, kp=number, kv="0", dampratio=None)
    else:
        edits.set(tag, gainprm=number, biasprm=f"0 -{number} 0")
