"""Physics that the file of a real arm lacks, or states wrongly, written by the benchmark itself.

An edit changes the model that MuJoCo compiles; a force acts in every step. exidyn's effects are not used:
these formulas are a second implementation. Dry friction is MuJoCo's own, with a limit that each step sets
anew; it sticks as the friction of the file does. The limits are

    Stribeck             Fs / (1 + (v / vs)^2)
    load                 mu |transmitted torque|

and the viscous friction of warming grease is Fw exp(-beta (T - 25 degC)) v, where the motor warms by a rise
that grows as 1 - exp(-t / tau). A cable is a spring k (q - q0) and a ripple a sin(n q).
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import mujoco
import numpy as np

COLD = 25.0
"""Temperature at which every run starts [degC]."""


class Item(NamedTuple):
    """One concealed thing."""

    kind: str  # Key of `EDITS`, of `FORCES`, or "delay"
    joints: tuple[int, ...]  # Joints that have it, from 0; empty for the base
    values: dict[str, float]  # Its values by name, in SI units


class Place(NamedTuple):
    """One joint of the robot in MuJoCo."""

    name: str  # Name of the joint
    actuator: int  # Index of its position servo
    qpos: int  # Index of its position
    dof: int  # Index of its degree of freedom


Values = dict[str, float]
Edit = Callable[[Any, Place, Values], None]
"""Changes a MjSpec at one joint."""
Force = Callable[[mujoco.MjModel, mujoco.MjData, Place, Values, float], None]
"""Adds to the forces of one joint in a step; the last argument is the transmitted torque [N m]."""


def temperature(values: Values, time: float | np.ndarray) -> Any:
    """Temperature of a motor some time after the start of a run [degC]."""
    return COLD + values["rise"] * (1.0 - np.exp(-time / values["tau"]))


def _kp(spec: Any, place: Place, values: Values) -> None:
    servo = spec.actuators[place.actuator]
    servo.gainprm[0] *= values["factor"]
    servo.biasprm[1] *= values["factor"]


def _kv(spec: Any, place: Place, values: Values) -> None:
    spec.actuators[place.actuator].biasprm[2] *= values["factor"]


def _forcerange(spec: Any, place: Place, values: Values) -> None:
    servo = spec.actuators[place.actuator]
    servo.forcelimited, servo.forcerange = True, [-values["limit"], values["limit"]]


def _mass(spec: Any, place: Place, values: Values) -> None:
    body = spec.joint(place.name).parent
    body.mass *= values["factor"]
    for name in ("inertia", "fullinertia"):
        setattr(body, name, getattr(body, name) * values["factor"])


def _tilt(spec: Any, place: Place, values: Values) -> None:
    angle, direction = values["angle"], values["direction"]
    sideways = np.array([np.cos(direction), np.sin(direction), 0.0])
    size = np.linalg.norm(spec.option.gravity)
    spec.option.gravity = size * (np.sin(angle) * sideways - [0.0, 0.0, np.cos(angle)])


def _gravcomp(spec: Any, place: Place, values: Values) -> None:
    for body in spec.bodies[1:]:
        body.gravcomp = values["share"]


def _spring(spec: Any, place: Place, values: Values) -> None:
    joint = spec.joint(place.name)
    set_number(joint, "stiffness", values["stiffness"])
    joint.springref = values["reference"]


def _adds(attribute: str) -> Edit:
    """An edit that adds a value of the same name to an attribute of the joint."""

    def edit(spec: Any, place: Place, values: Values) -> None:
        joint = spec.joint(place.name)
        set_number(joint, attribute, float(np.ravel(getattr(joint, attribute))[0]) + values[attribute])

    return edit


def set_number(joint: Any, attribute: str, value: float) -> None:
    """Set a number of a joint, which is the first of several where it is a polynomial's."""
    if np.ndim(getattr(joint, attribute)):
        getattr(joint, attribute)[0] = value
    else:
        setattr(joint, attribute, value)


def _stribeck(model: mujoco.MjModel, data: mujoco.MjData, place: Place, values: Values, load: float) -> None:
    ratio = data.qvel[place.dof] / values["velocity"]
    model.dof_frictionloss[place.dof] += values["torque"] / (1.0 + ratio**2)


def _load(model: mujoco.MjModel, data: mujoco.MjData, place: Place, values: Values, load: float) -> None:
    model.dof_frictionloss[place.dof] += values["mu"] * abs(load)


def _thermal(model: mujoco.MjModel, data: mujoco.MjData, place: Place, values: Values, load: float) -> None:
    warmth = temperature(values, max(data.time, 0.0)) - COLD
    model.dof_damping[place.dof] += values["damping"] * np.exp(-values["beta"] * warmth)


def _cable(model: mujoco.MjModel, data: mujoco.MjData, place: Place, values: Values, load: float) -> None:
    position = data.qpos[place.qpos]
    spring = values["stiffness"] * (position - values["reference"])
    data.qfrc_applied[place.dof] -= spring + values["ripple"] * np.sin(values["waves"] * position)


EDITS: dict[str, Edit] = {
    "kp": _kp,
    "kv": _kv,
    "forcerange": _forcerange,
    "coulomb": _adds("frictionloss"),
    "viscous": _adds("damping"),
    "armature": _adds("armature"),
    "mass": _mass,
    "tilt": _tilt,
    "gravcomp": _gravcomp,
    "spring": _spring,
}
FORCES: dict[str, Force] = {
    "stribeck": _stribeck, "load": _load, "thermal": _thermal, "cable": _cable,
}  # fmt: skip
