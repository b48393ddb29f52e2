"""mjlab: actuators of an arm for `EntityArticulationInfoCfg.actuators`.

An actuator of mjlab has one value for all its joints, so that each joint has its own. A delay counts physics
steps.
"""

from textwrap import indent

import numpy as np

from exidyn.quoting import python_text

from .portable import Portable
from .python_code import call, number, patterns, steps

FEATURES = ("armature", "damping", "dry", "servos", "law", "delay")
HEAD = '''"""Actuators of an arm for mjlab 1.6, by exidyn; SI units, at the joints.

EntityArticulationInfoCfg(actuators=ACTUATORS), for an MJCF without actuators of its own. {law}
"""

from mjlab.actuator import {kind}

ROBOT = {name}
{step}ACTUATORS = (
{actuators}
)
'''
STEP = "PHYSICS_STEP = 0.002  # MujocoCfg.timestep [s]: put that of your simulation here\n"
BY_SERVO = "stiffness and damping\nare those of the servos; viscous_damping is passive."
BY_EFFORT = "stiffness and damping\nare 0, for effort commands; put the gains of a position controller there."


def mjlab(portable: Portable) -> str:
    """Python for an mjlab configuration: limits, armature, friction, servos, delay; no bodies."""
    no_servos = portable.servos is None
    kind = "IdealPdActuatorCfg" if no_servos else "BuiltinPositionActuatorCfg"
    actuators = [call(kind, _arguments(portable, place)) for place in range(portable.robot.dof)]
    return HEAD.format(
        law=BY_EFFORT if no_servos else BY_SERVO,
        kind=kind,
        name=python_text(portable.robot.name),
        step=STEP if np.any(portable.law.delay) else "",
        actuators=indent(",\n".join(actuators) + ",", "    "),
    )


def _arguments(portable: Portable, place: int) -> dict[str, str]:
    """Arguments of one joint's actuator."""
    law, joints = portable.law, portable.joints
    [pattern] = patterns([portable.robot.joints[place]])
    arguments = {
        "target_names_expr": f"({pattern},)",
        "stiffness": number(law.stiffness[place]),
        "damping": number(law.damping[place]),
    }
    if np.isfinite(limit := portable.torque_limit[place]):
        arguments["effort_limit"] = number(limit)
    arguments["armature"] = number(max(joints.armature[place], 0.0))
    arguments["frictionloss"] = number(max(joints.dry[place], 0.0))
    arguments["viscous_damping"] = number(max(joints.damping[place], 0.0))
    if law.delay[place]:
        lag = steps(law.delay[place])
        arguments |= {"delay_min_lag": lag, "delay_max_lag": lag}
    return arguments
