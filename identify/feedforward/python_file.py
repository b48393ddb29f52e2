"""Python file of a feedforward: one straight-line function for each torque, on plain numbers."""

from textwrap import indent

import numpy as np

from exidyn.quoting import hash_comment, python_text

from ..dynamics.program import MATH, PYTHON, number, python_body
from .feedforward import Feedforward
from .file_parts import Function, functions, header

HEAD = '''"""Torque for gravity, friction and motion of a robot arm. Written by exidyn."""
{comments}

from math import {math}

import numpy as np

ROBOT = {name}
JOINTS = {joints}
BAND = np.array({band})
"""Speed below which friction is not compensated [rad/s]: at least 5 times the noise of your velocity."""
SHARE = {share}
"""Share of the friction that is compensated, below 1 [-]."""
{constants}

def _sign(x):
    return (x > 0.0) - (x < 0.0)


def _numbers(*arrays):
    return [a.tolist() if isinstance(a, np.ndarray) else a for a in arrays]

'''
COMPENSATION = '''

def friction_compensation({arguments}):
    """Torque against friction that is zero near rest and never drives the joint [{unit}]."""
    torque, speed = friction({arguments}), np.asarray(dq, float)
    s = np.minimum(np.maximum(np.abs(speed) / BAND - 1.0, 0.0), 1.0)
    return np.where(torque * speed > 0.0, SHARE * s * s * (3.0 - 2.0 * s) * torque, 0.0)


def compensation({arguments}):
    """Gravity plus friction compensation [{unit}]: the arm floats."""
    return gravity({still}) + friction_compensation({arguments})
'''
CURRENT = '''

def current(torque):
    """Motor currents for joint torques [A]."""
    return TO_MOTORS @ torque / DRIVE_GAIN
'''
OFFSET = '''

def position_offset({still}):
    """What the position servos sag by, to be added to the command [rad]."""
    return np.clip(gravity({still}), -SERVO_LIMIT, SERVO_LIMIT) / SERVO_STIFFNESS
'''


def python_file(feedforward: Feedforward) -> str:
    """Text of the file."""
    robot, unit = feedforward.robot, feedforward.unit
    parts = functions(feedforward.dynamics, unit, PYTHON)
    arguments = {part.name: ", ".join(part.arguments) for part in parts}
    names = {"arguments": arguments["friction"], "still": arguments["gravity"], "unit": unit}
    text = HEAD.format(
        comments="\n".join(hash_comment(line) for line in header(feedforward)),
        math=MATH,
        name=python_text(robot.name),
        joints=f"({''.join(f'{python_text(joint)}, ' for joint in robot.joints).rstrip()})",
        band=_list(feedforward.band),
        share=number(feedforward.share),
        constants=_constants(feedforward),
    )
    text += "\n".join(_function(part, robot.dof) for part in parts) + COMPENSATION.format(**names)
    text += CURRENT if feedforward.gain is not None else ""
    return text + (OFFSET.format(**names) if feedforward.servo is not None else "")


def _constants(feedforward: Feedforward) -> str:
    """Lines of constants that not every arm has."""
    lines = []
    if feedforward.gain is not None:
        lines.append(f"DRIVE_GAIN = np.array({_list(feedforward.gain)})  # joint torque per current [N m/A]")
        rows = ", ".join(_list(row) for row in feedforward.robot.to_motors)
        lines.append(f"TO_MOTORS = np.array([{rows}])  # motors that also turn with other joints")
    if feedforward.servo is not None:
        stiffness, limit = feedforward.servo.stiffness, feedforward.servo.limit
        lines.append(f"SERVO_STIFFNESS = np.array({_list(stiffness)})  # torque per position error [N m/rad]")
        lines.append(f"SERVO_LIMIT = np.array({_list(limit)})  # largest torque [N m]")
    return "\n".join([*lines, ""])


def _list(values: np.ndarray) -> str:
    return f"[{', '.join(number(v) if np.isfinite(v) else 'np.inf' for v in values)}]"


def _function(function: Function, joints: int) -> str:
    """Definition of a function, in which each input that is used has a variable of its own."""
    head = f'\ndef {function.name}({", ".join(function.arguments)}):\n    """{function.meaning}"""\n'
    arrays = ", ".join(function.arguments)
    body = f"{arrays}{',' * (len(function.arguments) == 1)} = _numbers({arrays})\n"
    body += "".join(f"{line}\n" for line in python_body(function.arguments, joints, function.lines))
    body += f"return np.array([{', '.join(function.lines.results)}])\n"
    return head + indent(body, "    ")
