"""Isaac Lab: actuators of an arm for `ArticulationCfg.actuators`.

The fields require Isaac Lab 2.3 or later; from 3.0 on, the limits also have other names.
"""

import re
from collections.abc import Callable
from textwrap import indent

import numpy as np

from exidyn.quoting import python_text

from ..arm.robot import Robot
from .portable import Portable

FEATURES = ("armature", "damping", "dry", "servos")
DIGITS = 6
"""Number of significant digits: solvers work in single precision."""

FIELDS: dict[str, Callable[[Portable], np.ndarray]] = {
    "effort_limit_sim": lambda portable: portable.robot.limits.torque,
    "velocity_limit_sim": lambda portable: portable.robot.limits.velocity,
    "stiffness": lambda portable: _stiffness(portable.robot),
    "damping": lambda portable: np.zeros(portable.robot.dof),
    "armature": lambda portable: np.maximum(portable.joints.armature, 0.0),
    "friction": lambda portable: np.maximum(portable.joints.dry, 0.0),
    "dynamic_friction": lambda portable: np.maximum(portable.joints.dry, 0.0),
    "viscous_friction": lambda portable: np.maximum(portable.joints.damping, 0.0),
}
"""Field of an actuator -> its value for each joint in SI units, shape (n,)."""
HEAD = '''"""Actuators of an arm for Isaac Lab, by exidyn; SI units, at the joints.

ArticulationCfg(..., actuators=ACTUATORS). {law}
"""

from isaaclab.actuators import ImplicitActuatorCfg

ROBOT = {name}
ACTUATORS = {{
    "arm": ImplicitActuatorCfg(
        joint_names_expr={joints},
'''
BY_SERVO = "stiffness is that of the servos; their own\ndamping is part of viscous_friction, so damping is 0."
BY_EFFORT = "stiffness and damping are 0, for effort\ncommands; put the gains of a position controller there."


def isaac(portable: Portable) -> str:
    """Python for an Isaac Lab configuration: limits, armature, friction, servos; no bodies."""
    robot = portable.robot
    law = BY_EFFORT if robot.servo is None else BY_SERVO
    patterns = [re.escape(joint) for joint in robot.joints]
    head = HEAD.format(name=python_text(robot.name), law=law, joints=_listed(patterns))
    rows = [
        f"{name}={_by_joint(patterns, values(portable))},"
        for name, values in FIELDS.items()
        if np.any(np.isfinite(values(portable)))
    ]
    return head + indent("\n".join(rows), " " * 8) + "\n    ),\n}\n"


def _stiffness(robot: Robot) -> np.ndarray:
    if robot.servo is None:
        return np.zeros(robot.dof)
    return np.abs(robot.drive_gain) * robot.servo.gain


def _listed(patterns: list[str]) -> str:
    return f"[{', '.join(map(python_text, patterns))}]"


def _by_joint(patterns: list[str], values: np.ndarray) -> str:
    """One number if all joints have the same value, else a number for each joint with a finite value."""
    if np.all(values == values[0]):
        return _number(values[0])
    known = [(p, v) for p, v in zip(patterns, values, strict=True) if np.isfinite(v)]
    rows = "".join(f"    {python_text(pattern)}: {_number(value)},\n" for pattern, value in known)
    return f"{{\n{rows}}}"


def _number(value: float) -> str:
    return repr(float(f"{value:.{DIGITS}g}"))
