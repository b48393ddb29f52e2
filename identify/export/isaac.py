"""Isaac Lab: actuators of an arm for `ArticulationCfg.actuators`.

The fields are those of Isaac Lab 3.0. An explicit actuator limits its own torque (`actuator_effort_limit`);
an implicit one leaves that to the solver (`joint_effort_limit`). A delay counts physics steps.
"""

from collections.abc import Callable
from textwrap import indent

import numpy as np

from exidyn.quoting import python_text

from .portable import Portable
from .python_code import by_joint, call, patterns, steps

FEATURES = ("armature", "damping", "dry", "static", "servos", "law", "delay")

FIELDS: dict[str, Callable[[Portable], np.ndarray]] = {
    "joint_velocity_limit": lambda portable: portable.robot.limits.velocity,
    "stiffness": lambda portable: portable.law.stiffness,
    "damping": lambda portable: portable.law.damping,
    "armature": lambda portable: np.maximum(portable.joints.armature, 0.0),
    "friction": lambda portable: portable.static_friction,
    "dynamic_friction": lambda portable: np.maximum(portable.joints.dry, 0.0),
    "viscous_friction": lambda portable: np.maximum(portable.joints.damping, 0.0),
}
"""Field of an actuator -> its value for each joint in SI units, shape (n,)."""
HEAD = '''"""Actuators of an arm for Isaac Lab 3.0, by exidyn; SI units, at the joints.

ArticulationCfg(..., actuators=ACTUATORS). {law}
In Isaac Lab 2.3, joint_effort_limit is effort_limit_sim, joint_velocity_limit is velocity_limit_sim, and
actuator_effort_limit is effort_limit.
"""

from isaaclab.actuators import {classes}

ROBOT = {name}
{step}ACTUATORS = {{
{actuators}
}}
'''
STEP = "PHYSICS_STEP = 0.005  # sim.dt [s]: put that of your simulation here\n"
BY_SERVO = "stiffness and damping are those of the servos; viscous_friction is passive."
BY_EFFORT = "stiffness and damping are 0, for effort\ncommands; put the gains of a position controller there."


def isaac(portable: Portable) -> str:
    """Python for an Isaac Lab configuration: limits, armature, friction, servos, delay; no bodies."""
    delays = portable.law.delay
    groups = {float(delay): np.flatnonzero(delays == delay) for delay in delays}
    names = ["arm"] if len(groups) == 1 else [f"arm{place}" for place in range(1, len(groups) + 1)]
    entries = [
        f"{python_text(name)}: {_actuator(portable, places, delay)},"
        for name, (delay, places) in zip(names, groups.items(), strict=True)
    ]
    return HEAD.format(
        law=BY_EFFORT if portable.servos is None else BY_SERVO,
        classes=", ".join(sorted({_class(delay) for delay in groups})),
        name=python_text(portable.robot.name),
        step=STEP if any(groups) else "",
        actuators=indent("\n".join(entries), "    "),
    )


def _class(delay: float) -> str:
    return "DelayedPDActuatorCfg" if delay else "ImplicitActuatorCfg"


def _actuator(portable: Portable, places: np.ndarray, delay: float) -> str:
    """The configuration of the joints with one delay [s], by their indices."""
    joints = [portable.robot.joints[place] for place in places]
    limit = "actuator_effort_limit" if delay else "joint_effort_limit"
    values = {limit: portable.torque_limit} | {name: field(portable) for name, field in FIELDS.items()}
    arguments = {"joint_names_expr": f"[{', '.join(patterns(joints))}]"}
    for name, of_all in values.items():
        if np.any(np.isfinite(of_all[places])):
            arguments[name] = by_joint(joints, of_all[places])
    if delay:
        arguments |= {"min_delay": steps(delay), "max_delay": steps(delay)}
    return call(_class(delay), arguments)
