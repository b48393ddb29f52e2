"""A real arm: plain MuJoCo with the user's file, edits of its numbers, and forces applied in every step.

Steps and integrator are those of the file, so an arm with nothing concealed is the simulation of its file.

Physics that the file of a real arm lacks, or states wrongly, written by the benchmark itself.

An edit changes the model that MuJoCo compiles; a force acts in every step. exidyn's effects are not used:
these formulas are a second implementation. Dry friction is MuJoCo's own, with a limit that each step sets
anew; it sticks as the friction of the file does. The limits are

    Stribeck             Fs / (1 + (v / vs)^2)
    load                 mu |transmitted torque|

and the viscous friction of warming grease is Fw exp(-beta (T - 25 degC)) v, where the motor warms by a rise
that grows as 1 - exp(-t / tau). A cable is a spring k (q - q0) and a ripple a sin(n q).
"""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
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


SETTLE = 1.0
"""Time for which the arm holds its first command before a run [s]."""


class Motion(NamedTuple):
    """What a real arm does; n joints, t samples, without the errors of sensors."""

    time: np.ndarray  # Time, shape (t,) [s]
    command: np.ndarray  # Commanded positions, shape (t, n) [rad]
    position: np.ndarray  # Positions, shape (t, n) [rad]
    velocity: np.ndarray  # Velocities, shape (t, n) [rad/s]
    torque: np.ndarray  # Torques of the motors, means over a sampling period, (t, n) [N m]
    # What MuJoCo's sensors of these torques read, which take an implicit damping at the velocity before the
    # step, shape (t, n) [N m]
    sensed: np.ndarray


def places_of(model: mujoco.MjModel, joints: Sequence[str]) -> list[Place]:
    """Where joints and their position servos are in a compiled model."""
    places = []
    for name in joints:
        joint = model.joint(name)
        on_joints = model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT
        [servo] = np.flatnonzero(on_joints & (model.actuator_trnid[:, 0] == joint.id))
        places.append(Place(name, int(servo), int(joint.qposadr[0]), int(joint.dofadr[0])))
    return places


def interpolated(
    moments: np.ndarray, time: np.ndarray, values: np.ndarray, delay: np.ndarray | float = 0.0
) -> np.ndarray:
    """Values (t, n) between samples, each column delayed by its delay [s], shape (k, n)."""
    delays = np.broadcast_to(delay, values.shape[1])
    columns = zip(values.T, delays, strict=True)
    return np.stack([np.interp(moments - later, time, column) for column, later in columns], axis=1)


class RealArm:
    """A user's file, the joints that are logged and commanded, and what the arm has and the file lacks."""

    def __init__(self, path: Path, joints: Sequence[str], items: Sequence[Item]) -> None:
        spec = mujoco.MjSpec.from_file(str(path))
        self.places = places_of(original := spec.compile(), joints)
        _keep_damping(spec, original)
        self.delay = np.zeros(len(joints))
        self._forces = []
        for item in items:
            for joint in item.joints or (0,):
                place = self.places[joint]
                if item.kind in EDITS:
                    EDITS[item.kind](spec, place, item.values)
                elif item.kind in FORCES:
                    self._forces.append((FORCES[item.kind], place, item.values))
                else:
                    self.delay[joint] = item.values["seconds"]
        self.model = spec.compile()
        self._spec, self._base = spec, (self.model.dof_frictionloss.copy(), self.model.dof_damping.copy())

    def text(self) -> str:
        """The file that states every number of this arm that MJCF can state, with delays."""
        for place, delay in zip(self.places, self.delay, strict=True):
            if delay:
                servo, step = self._spec.actuators[place.actuator], self.model.opt.timestep
                servo.delay, servo.nsample, servo.interp = delay, int(np.ceil(delay / step)) + 2, 1
        self._spec.compile()
        return str(self._spec.to_xml())

    def follow(self, time: np.ndarray, command: np.ndarray) -> Motion:
        """The motion by commands (t, n) [rad], linear between samples; the arm starts cold and at rest."""
        dofs, qpos = ([getattr(place, name) for place in self.places] for name in ("dof", "qpos"))
        data = mujoco.MjData(self.model)
        data.qpos[qpos], data.time = command[0], -SETTLE
        stride = round((time[1] - time[0]) / self.model.opt.timestep)
        settling = round(SETTLE / self.model.opt.timestep)
        steps = np.arange(-settling, stride * len(time)) * self.model.opt.timestep
        states, torques = [], []
        for torque in self._steps(data, interpolated(steps, time, command, self.delay)):
            torques.append(torque[dofs])
            states.append((data.qpos[qpos], data.qvel[dofs], data.qfrc_actuator[dofs]))
        # A state is that behind a step: the one before step `settling` belongs to the first sample.
        rows = settling - 1 + stride * np.arange(len(time))
        position, velocity = (np.array([states[row][part] for row in rows]) for part in (0, 1))
        sensed = np.array([states[row + 1][2] for row in rows])
        return Motion(
            time, command, position, velocity, _centered(np.array(torques), rows + 1, stride), sensed
        )

    def _steps(self, data: mujoco.MjData, control: np.ndarray) -> Iterator[np.ndarray]:
        """Step with the control of each step, shape (k, n); yields the torque of the motors (nv,) [N m]."""
        model, actuators = self.model, [place.actuator for place in self.places]
        load = np.zeros(model.nv)
        for row in control:
            data.ctrl[actuators] = row
            self._apply(data, load)
            before = data.qvel.copy()
            mujoco.mj_step(model, data)
            change = data.qvel - before
            if self._forces:
                load = _transmitted(model, data, change / model.opt.timestep)
            yield data.qfrc_actuator + self._implicit(data, change)

    def _apply(self, data: mujoco.MjData, load: np.ndarray) -> None:
        """Set friction and forces of the next step; dry friction takes the load (nv,) of the last [N m]."""
        if self._forces:
            self.model.dof_frictionloss[:], self.model.dof_damping[:] = self._base
            data.qfrc_applied[:] = 0.0
        for force, place, values in self._forces:
            force(self.model, data, place, values, float(load[place.dof]))

    def _implicit(self, data: mujoco.MjData, change: np.ndarray) -> np.ndarray:
        """What an implicit integrator adds to the torque of servos that are not at their limit (nv,) [N m].

        It takes their damping at the velocity behind the step, which has changed by `change` (nv,) [rad/s].
        """
        model, more = self.model, np.zeros(self.model.nv)
        if model.opt.integrator == mujoco.mjtIntegrator.mjINT_EULER:
            return more
        for place in self.places:
            force, limits = data.actuator_force[place.actuator], model.actuator_forcerange[place.actuator]
            limited = model.actuator_forcelimited[place.actuator] and not limits[0] < force < limits[1]
            damping = 0.0 if limited else -model.actuator_biasprm[place.actuator, 2]
            more[place.dof] = -damping * change[place.dof]
        return more


def _keep_damping(spec: Any, original: mujoco.MjModel) -> None:
    """Write the damping of servos, which MuJoCo else computes anew from changed inertia (dampratio)."""
    for index, servo in enumerate(spec.actuators):
        if original.actuator_biastype[index] == mujoco.mjtBias.mjBIAS_AFFINE:
            servo.biasprm[2] = original.actuator_biasprm[index, 2]


def _transmitted(model: mujoco.MjModel, data: mujoco.MjData, acceleration: np.ndarray) -> np.ndarray:
    """Torque that moves and holds the links (nv,), without rotors and friction [N m]."""
    inertial = np.empty(model.nv)
    mujoco.mj_mulM(model, data, inertial, acceleration)
    return np.asarray(inertial - model.dof_armature * acceleration + data.qfrc_bias)


def _centered(torques: np.ndarray, rows: np.ndarray, stride: int) -> np.ndarray:
    """Mean of torques of steps (k, n) over half a sampling period on both sides of each row, shape (t, n)."""
    sums = np.vstack([np.zeros_like(torques[:1]), np.cumsum(torques, axis=0)])
    half = max(stride // 2, 1)
    stop = np.minimum(rows + half, len(torques))
    return np.asarray((sums[stop] - sums[rows - half]) / (stop - rows + half)[:, None])
