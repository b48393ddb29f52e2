"""Attached: effects of an arm that MJCF cannot express, applied as forces in every step of MuJoCo."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..effects import CurrentOffset, Effect, ViscousFriction, name_of
from ..effects.simulator_terms import JointTerms
from ..errors import RobotError
from ..export.mjcf_patch import accepted, described, require_same
from ..export.portable import Portable
from ..model import Model
from ..notebook import optional
from ..robot_files.mjcf_elements import actuators, enum_of
from .callbacks import PURPOSE, Layout, library, register, release
from .switched_off import MotorFriction
from .torques import Share, Torques

READ = ("qpos", "qvel", "qacc", "qfrc_passive", "qfrc_spring", "qfrc_gravcomp")
PATCH = ". Write the estimates into the file first: exidyn export FIT --to mjcf --patch ARM.xml"
WHERE = "the model"

Pair = tuple[Effect, np.ndarray]


def lacking(model: Any, arm: Model, payload: str = "") -> tuple[Portable, list[Pair]]:
    """The arm as a portable model, and the effects that MuJoCo's model lacks, with their values (p,).

    Dry friction is among them, because MuJoCo models it by another law. Raises `RobotError` if the model
    describes another arm or has other values, or if an effect cannot be attached.
    """
    wanted = Portable.of(arm, payload)
    held, _ = accepted(wanted)
    without_dry = replace(held, joints=replace(held.joints, dry=np.zeros(arm.robot.dof)))
    compiled = described(model, wanted, WHERE)
    compiled_joints = Portable.of(compiled).joints
    require_same(without_dry, _without_dry(compiled), WHERE, (PATCH, PATCH))
    pairs = [
        pair for pair in wanted.model.shares(wanted.model.nominal_values) if _lacks(pair[0], wanted, pair[1])
    ]
    offset = wanted.joints.constant - compiled_joints.constant + _motor_bias(model, arm.robot.joints)
    # Negative damping estimates: MuJoCo is given zero instead.
    damping = wanted.joints.damping - held.joints.damping
    corrections = ((CurrentOffset(), offset), (ViscousFriction(), damping))
    pairs += [(effect, values) for effect, values in corrections if values.any()]
    for effect, _ in pairs:
        _require_possible(effect, model)
    return wanted, pairs


def _motor_bias(model: Any, joints: Sequence[str]) -> np.ndarray:
    """Constant torque of the motors in the file, where exidyn's export writes it, shape (n,) [N m]."""
    ids, torque = [int(model.joint(name).id) for name in joints], np.zeros(len(joints))
    kind, affine = enum_of("mjtTrn", "mjTRN_JOINT"), enum_of("mjtBias", "mjBIAS_AFFINE")
    for actuator in actuators(model):
        if model.actuator_biastype[actuator] != affine:
            continue
        joint, (bias, *others) = int(model.actuator_trnid[actuator][0]), model.actuator_biasprm[actuator][:3]
        if model.actuator_trntype[actuator] == kind and joint in ids and not any(others):
            torque[ids.index(joint)] += model.actuator_gear[actuator][0] * bias
    return torque


def _without_dry(compiled: Model) -> Model:
    effects = tuple(effect for effect in compiled.effects if not getattr(effect, "dry", False))
    names = replace(compiled, effects=effects, stated={}).names
    stated = {name: value for name, value in compiled.stated.items() if name in names}
    return replace(compiled, effects=effects, stated=stated)


def _lacks(effect: Effect, wanted: Portable, values: np.ndarray) -> bool:
    """Whether MJCF lacks the effect, or models it by another law."""
    if effect.of_links or effect.payload or not values.any():
        return False
    form = effect.portable(wanted.robot, values)
    return not isinstance(form, JointTerms) or bool(np.any(form.dry))


def _require_possible(effect: Effect, model: Any) -> None:
    """Refuse effects that callbacks cannot apply."""
    if not effect.massless:
        raise RobotError(
            f"{name_of(effect)} depends on acceleration across joints, which MuJoCo's callbacks cannot add "
            "to the inertia; simulate the arm with exidyn simulate instead"
        )
    if not effect.pointwise and model.opt.integrator == enum_of("mjtIntegrator", "mjINT_RK4"):
        raise RobotError(
            f"{name_of(effect)} depends on past positions, and RK4 evaluates positions that the arm never "
            'reaches. Use integrator="implicitfast"'
        )


def _require_callbacks(model: Any, data: Any) -> None:
    """Refuse models and data that MuJoCo itself does not step."""
    mujoco = optional("mujoco", PURPOSE, "mujoco")
    if not isinstance(model, mujoco.MjModel) or not isinstance(data, mujoco.MjData):
        kinds = f"{type(model).__module__}.{type(model).__name__}"
        raise RobotError(
            f"effects attach to mujoco.MjModel and MjData, not to {kinds}: MJX and Warp have no callbacks in "
            "their steps. They do read parameters from MJCF: exidyn export FIT --to mjcf --patch ARM.xml"
        )


class State(NamedTuple):
    """State of the effects for one `MjData`."""

    address: int  # address of the `MjData`
    torques: Torques  # effects on the motor side of the gears
    transmitted: Torques  # effects whose torque the gears transmit
    arrays: dict[str, np.ndarray]  # arrays of the `MjData`, by name
    pointer: int  # address of the positions, which distinguishes it from a later `MjData` at the same address
    clock: Any  # simulation time of the `MjData`
    last: list[float]  # time of the last update, a list of one number [s]
    velocity: np.ndarray  # velocity at that time, shape (n,) [rad/s]
    acceleration: np.ndarray  # mean acceleration over the preceding step, shape (n,) [rad/s^2]
    drag: np.ndarray  # damping coefficient in this step, shape (n,) [N m s/rad]


class Attached:
    """Effects that act in every step of one model, with any of its data, until `detach`.

    Args:
        model: An `MjModel`; its `dof_frictionloss`, and the LuGre friction and cogging of its DC motors, are
            zero while the effects are attached.
        data: An `MjData` of the model.
        arm: The arm, with the estimates as its nominal values.
        payload: Name of the payload that is part of the last link; empty for none.
        temperature: Joint temperature, one number or one per joint, used where friction depends on it; the
            attribute `temperature` can be changed later [degC].

    Attributes:
        effects: Names of the attached effects.
        temperature: Joint temperature, shape (n,) [degC].

    Raises:
        RobotError: If the model describes another arm or has other values, or an effect cannot be attached.
    """

    def __init__(self, model: Any, data: Any, arm: Model, payload: str = "", temperature: Any = 25.0) -> None:
        _require_callbacks(model, data)
        wanted, pairs = lacking(model, arm, payload)
        self._model, self._robot = model, wanted.robot
        self._transmitted = [pair for pair in pairs if pair[0].transmitted]
        self._motor_side = [pair for pair in pairs if not pair[0].transmitted]
        self.effects = tuple(dict.fromkeys(name_of(effect) for effect, _ in pairs))
        self.temperature = np.broadcast_to(np.asarray(temperature, float), (wanted.robot.dof,)).copy()
        inertia = "M" if hasattr(data, "M") else "qM"
        self._layout = Layout.of(data, (*READ, inertia))
        joints = [model.joint(name) for name in wanted.robot.joints]
        self._dofs = np.array([int(joint.dofadr[0]) for joint in joints])
        self._qpos = np.array([int(joint.qposadr[0]) for joint in joints])
        ends = model.M_rowadr + model.M_rownnz - 1 if inertia == "M" else model.dof_Madr
        self._diagonal = ends[self._dofs]
        self._inertia, self._library, self._states = inertia, library(), dict[int, State]()
        self._bias = np.zeros(model.nv)
        self._needs_load = any(effect.needs_load for effect, _ in self._motor_side)
        self._dry = model.dof_frictionloss[self._dofs].copy()
        self._of_motors = MotorFriction(model, [int(joint.id) for joint in joints])
        # All effects are evaluated once here, because an exception inside a callback would be lost.
        state = self._state(int(data._address))
        self._torque(state)
        state.torques.memory.forget()
        state.transmitted.memory.forget()
        register(model, self)
        model.dof_frictionloss[self._dofs] = 0.0
        self._of_motors.remove()

    def __enter__(self) -> "Attached":
        return self

    def __exit__(self, *_: object) -> None:
        self.detach()

    def detach(self) -> None:
        """Remove the effects and restore the model."""
        release(self._model)
        self._model.dof_frictionloss[self._dofs] = self._dry
        self._of_motors.restore()

    def passive(self, data: int) -> None:
        """Add the forces; MuJoCo calls it after it has summed passive forces."""
        state = self._state(data)
        self._update(state)
        torque, state.drag[:] = self._torque(state)
        state.arrays["qfrc_passive"][self._dofs] -= torque

    def control(self, data: int) -> None:
        """Make friction implicit by adding step times drag to the inertia.

        MuJoCo calls it before actuators, in steps but not in inverse dynamics.
        """
        state = self._state(data)
        state.arrays[self._inertia][self._diagonal] += self._model.opt.timestep * state.drag
        self._library.mj_factorM(self._model._address, data)

    def _state(self, data: int) -> State:
        """State of the effects for the `MjData` at an address."""
        state = self._states.get(data)
        pointer = self._layout.pointer(data, "qpos")
        if state is None or state.pointer != pointer:
            arrays = {name: self._layout.array(data, name) for name in self._layout.places}
            motor_side = Torques(self._robot, self._motor_side)
            transmitted = Torques(self._robot, self._transmitted)
            clock, zeros = self._layout.clock(data), np.zeros((3, len(self._dofs)))
            state = State(data, motor_side, transmitted, arrays, pointer, clock, [np.inf], *zeros)
            self._states[data] = state
        return state

    def _update(self, state: State) -> None:
        """Store the current motion once per step; start over after a reset."""
        now, [last] = state.clock.value, state.last
        if now == last:
            return
        velocity = state.arrays["qvel"][self._dofs]
        if now < last:
            state.torques.memory.forget()
            state.acceleration[:] = state.arrays["qacc"][self._dofs]
        else:  # qacc lacks what the integrator makes implicit, such as the damping of servos
            state.acceleration[:] = (velocity - state.velocity) / (now - last)
        state.velocity[:], state.last[0] = velocity, now
        state.torques.memory.remember(state.arrays["qpos"][self._qpos])

    def _torque(self, state: State) -> Share:
        """Torque of all effects."""
        position, velocity = state.arrays["qpos"][self._qpos], state.arrays["qvel"][self._dofs]
        step, load = self._model.opt.timestep, np.zeros(len(velocity))
        transmitted = None
        if self._transmitted:
            transmitted = state.transmitted.at(position, velocity, step, load, self.temperature)
        if self._needs_load:
            load = self._load(state) + (transmitted.torque if transmitted else 0.0)
        motor_side = state.torques.at(position, velocity, step, load, self.temperature)
        if transmitted is None:
            return motor_side
        return Share(motor_side.torque + transmitted.torque, motor_side.drag + transmitted.drag)

    def _load(self, state: State) -> np.ndarray:
        """Torque transmitted by the gears at the acceleration of the preceding step, shape (n,) [N m].

        Where no step led to this state, as in inverse dynamics, the acceleration is `qacc`.
        """
        arrays = state.arrays
        qacc = arrays["qacc"][self._dofs]
        if np.array_equal(arrays["qvel"][self._dofs], state.velocity):
            arrays["qacc"][self._dofs] = state.acceleration
        self._library.mj_rne(self._model._address, state.address, 1, self._bias.ctypes.data)
        arrays["qacc"][self._dofs] = qacc
        return (self._bias - arrays["qfrc_spring"] - arrays["qfrc_gravcomp"])[self._dofs]
