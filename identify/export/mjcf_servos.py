"""Gains of a file's position servos: identified kp, and unchanged damping.

In logs without current, the position error takes its place, and a drive gain is the kp of a servo. The
damping of the servo is then part of the identified viscous friction, so its own damping becomes zero. Other
servos keep their damping, which MuJoCo derives from the inertia if the file has a `dampratio`.
"""

from collections.abc import Collection, Iterator
from typing import Any

import numpy as np

from ..arm.robot import Robot
from ..errors import RobotError
from ..robot_files.mjcf_dcmotors import is_dc_motor
from ..robot_files.mjcf_drives import servos
from ..robot_files.mjcf_names import actuators, name_of
from ..text_table import NORMAL_95
from .mjcf_changes import DIGITS, SAME, Change, File, nearly_equal
from .portable import Portable
from .xml_text import Edits


def servo_changes(file: File, portable: Portable, edits: Edits) -> Iterator[Change]:
    """Write the stiffness of all servos, if the drives of robot and file are servos; yields the changes."""
    robot = portable.robot
    for place, actuator in enumerate(written_servos(file, portable)):
        wanted = stiffness(robot)[place]
        where = f"actuator '{name_of(file.compiled, 'actuator', actuator)}'"
        old, damping = _gains(file.compiled, actuator)
        gear = float(file.compiled.actuator_gear[actuator][0])
        if nearly_equal(old * gear**2, float(wanted)) and not damping:
            continue
        _write(file, actuator, float(wanted) / gear**2, edits)
        half = NORMAL_95 * float(robot.drive_gain_tolerance[place] * wanted) / gear**2
        yield Change(where, "kp", robot.unit(place, "N m/rad"), old, float(wanted) / gear**2, half)
        if damping:
            unit = robot.unit(place, "N m s/rad")
            yield Change(where, "kv", unit, damping, 0.0, np.inf, "now in damping")


def written_servos(file: File, portable: Portable) -> list[int]:
    """Servos whose gains are written: those of all joints, if the drives of the robot are servos."""
    return servos(file.compiled, portable.robot.joints) if portable.robot.servo is not None else []


def keep_damping(file: File, new: Any, written: Collection[int], edits: Edits) -> Iterator[Change]:
    """Write the original damping of servos if the changes have altered it; yields the changes."""
    old = file.compiled
    for actuator in actuators(old):
        original, altered = (_gains(model, actuator)[1] for model in (old, new))
        tag = file.elements.position_servo(actuator)
        if tag is not None and actuator not in written and not nearly_equal(original, altered):
            if tag.name == "general":  # MuJoCo takes a positive third number for a dampratio
                offset, stiffness = old.actuator_biasprm[actuator][:2]
                edits.set(tag, biasprm=f"{offset:.{DIGITS}g} {stiffness:.{DIGITS}g} {-original:.{DIGITS}g}")
            else:
                edits.set(tag, dampratio=None, kv=f"{original:.{DIGITS}g}")
            where = f"servo '{name_of(old, 'actuator', actuator)}', instead of dampratio"
            yield Change(where, "kv", "N m s/rad", altered, original, 0.0)


def altered_damping(old: Any, new: Any, written: Collection[int]) -> list[str]:
    """Sentences about servos of included files, whose damping MuJoCo computes from the new inertia."""
    unwritten = [a for a in actuators(old) if a not in written and not is_dc_motor(old, a)]
    pairs = [(a, _gains(old, a)[1], _gains(new, a)[1]) for a in unwritten]
    return [
        f"dampratio of servo '{name_of(old, 'actuator', actuator)}' in an included file gives it kv "
        f"{after:.4g} instead of {before:.4g}; write kv there"
        for actuator, before, after in pairs
        if not nearly_equal(before, after)
    ]


def require_servos(compiled: Any, portable: Portable, where: str) -> None:
    """Raise `RobotError` unless the servos compiled from the new text have the intended gains."""
    robot, actuators = portable.robot, servos(compiled, portable.robot.joints)
    for actuator, wanted in zip(actuators, stiffness(robot) if robot.servo else (), strict=False):
        kp, damping = _gains(compiled, actuator)
        made = kp * float(compiled.actuator_gear[actuator][0]) ** 2
        if abs(made - wanted) > SAME * wanted or damping:
            raise RobotError(
                f"{where}: actuator '{name_of(compiled, 'actuator', actuator)}' has kp {made:.4g} and kv "
                f"{damping:.4g} in MuJoCo, not {wanted:.4g} and 0 as in its element"
            )


def stiffness(robot: Robot) -> np.ndarray:
    """Torque per position error of each servo, shape (n,) [N m/rad]."""
    return np.ones(robot.dof) if robot.servo is None else np.abs(robot.drive_gain) * robot.servo.gain


def _gains(compiled: Any, actuator: int) -> tuple[float, float]:
    """The kp and kv of a servo."""
    return float(compiled.actuator_gainprm[actuator][0]), -float(compiled.actuator_biasprm[actuator][2]) + 0.0


def _write(file: File, actuator: int, kp: float, edits: Edits) -> None:
    tag, number = file.elements.actuator(actuator), f"{kp:.{DIGITS}g}"
    if tag.name == "position":
        edits.set(tag, kp=number, kv="0", dampratio=None)
    else:
        edits.set(tag, gainprm=number, biasprm=f"0 -{number} 0")
