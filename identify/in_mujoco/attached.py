"""Attached: what MJCF lacks of an arm, as forces in every step of MuJoCo's."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..effects import CurrentOffset, Effect, ViscousFriction, name_of
from ..effects.simulator_terms import JointTerms
from ..errors import RobotError
from ..export.mjcf_same import Remedy, accepted, described, require_same
from ..export.portable import Portable
from ..model import Model
from ..notebook import optional
from ..robot_files.mjcf_names import enum_of
from .callbacks import PURPOSE, library, register, release
from .memory import Layout, step_address
from .native import Native, possible, terms_of
from .torques import Share, Torques

READ = ("qpos", "qvel", "qacc", "qfrc_passive", "qfrc_spring", "qfrc_gravcomp")
PATCH = ". Write what was found into the file first: exidyn export FIT --to mjcf --patch ARM.xml"
UNPATCHED = Remedy(PATCH, PATCH)
WHERE = "the model"

Pair = tuple[Effect, np.ndarray]


def lacking(model: Any, arm: Model, payload: str = "") -> tuple[Portable, list[Pair]]:
    """The arm as MuJoCo has it, and its effects with their values (p,) that MuJoCo's model lacks.

    Dry friction is among them: MuJoCo's is another law.

    Raises:
        RobotError: The model is of another arm, or has other numbers; or an effect cannot be attached.
    """
    wanted = Portable.of(arm, payload)
    kept, _ = accepted(wanted)
    without = replace(kept, joints=replace(kept.joints, dry=np.zeros(arm.robot.dof)))
    file = described(model, wanted, WHERE)
    made = Portable.of(file).joints
    require_same(without, _without_dry(file), WHERE, UNPATCHED)
    pairs = [
        pair for pair in wanted.model.shares(wanted.model.nominal_values) if _lacks(pair[0], wanted, pair[1])
    ]
    offset = wanted.joints.constant - made.constant + _biases(model, arm.robot.joints)
    # Where damping below zero was found, which MuJoCo is not given.
    drag = wanted.joints.damping - kept.joints.damping
    left = ((CurrentOffset(), offset), (ViscousFriction(), drag))
    pairs += [(effect, own) for effect, own in left if own.any()]
    for effect, _ in pairs:
        _require_possible(effect, model)
    return wanted, pairs


def _biases(model: Any, joints: Sequence[str]) -> np.ndarray:
    """Constant torque that motors of the file add, as files of exidyn's export have it, shape (n,) [N m]."""
    ids, torque = [int(model.joint(name).id) for name in joints], np.zeros(len(joints))
    kind = enum_of("mjtTrn", "mjTRN_JOINT")
    for actuator in range(model.nu):
        joint, (bias, *others) = int(model.actuator_trnid[actuator][0]), model.actuator_biasprm[actuator][:3]
        if model.actuator_trntype[actuator] == kind and joint in ids and not any(others):
            torque[ids.index(joint)] += model.actuator_gear[actuator][0] * bias
    return torque


def _without_dry(file: Model) -> Model:
    kept = tuple(effect for effect in file.effects if not getattr(effect, "dry", False))
    names = replace(file, effects=kept, stated={}).names
    return replace(file, effects=kept, stated={name: p for name, p in file.stated.items() if name in names})


def _lacks(effect: Effect, wanted: Portable, values: np.ndarray) -> bool:
    """Whether MJCF has no such effect, or has it by another law."""
    if effect.of_links or effect.payload or not values.any():
        return False
    form = effect.portable(wanted.robot, values)
    return not isinstance(form, JointTerms) or bool(np.any(form.dry))


def _require_possible(effect: Effect, model: Any) -> None:
    """Refuse what callbacks cannot hold.

    Raises:
        RobotError: Torque by acceleration, or a memory under an integrator that tries steps.
    """
    if not effect.massless:
        raise RobotError(
            f"{name_of(effect)} is torque by acceleration between joints, which MuJoCo's callbacks cannot "
            "add to its inertia; simulate it with exidyn simulate"
        )
    if not effect.pointwise and model.opt.integrator == enum_of("mjtIntegrator", "mjINT_RK4"):
        raise RobotError(
            f"{name_of(effect)} remembers where the arm was, and RK4 tries places where it never is. Use "
            'integrator="implicitfast"'
        )


def _require_callbacks(model: Any, data: Any) -> None:
    """Refuse models of what steps elsewhere.

    Raises:
        RobotError: It is of MJX or Warp.
    """
    mujoco = optional("mujoco", PURPOSE, "mujoco")
    if not isinstance(model, mujoco.MjModel) or not isinstance(data, mujoco.MjData):
        kinds = f"{type(model).__module__}.{type(model).__name__}"
        raise RobotError(
            f"effects attach to mujoco.MjModel and MjData, not to {kinds}: MJX and Warp call nobody back in "
            "their steps. What MJCF itself holds they take: exidyn export FIT --to mjcf --patch ARM.xml"
        )


class State(NamedTuple):
    """Of the effects in one of MuJoCo's data.

    Attributes:
        address: Of the data.
        torques: Effects on the motors' side of the gears.
        transmitted: Those that the gears carry.
        arrays: Of the data, by name.
        pointer: To its positions, by which other data at the same address are told apart.
        clock: Its time.
        last: The time at which memories are, one number [s].
        velocity: At that time, shape (n,) [rad/s].
        acceleration: Over the step before it, shape (n,) [rad/s^2].
        drag: Torque by velocity in this step, shape (n,) [N m s/rad].
    """

    address: int
    torques: Torques
    transmitted: Torques
    arrays: dict[str, np.ndarray]
    pointer: int
    clock: Any
    last: list[float]
    velocity: np.ndarray
    acceleration: np.ndarray
    drag: np.ndarray


class Attached:
    """Effects that act in every step of one model, with whichever data, until `detach`.

    Args:
        model: MuJoCo's, an `MjModel`; its `dof_frictionloss` is zero while they are attached.
        data: One `MjData` of it.
        arm: The arm, what was found as its nominal values.
        payload: Name of the payload that is part of its last link; empty for none.
        temperature: Of the joints, where friction depends on it; `temperature` can be written later [degC].

    Attributes:
        effects: Names of those that are attached.
        temperature: Shape (n,) [degC].

    Raises:
        RobotError: See `lacking`.
    """

    def __init__(self, model: Any, data: Any, arm: Model, payload: str = "", temperature: Any = 25.0) -> None:
        _require_callbacks(model, data)
        wanted, pairs = lacking(model, arm, payload)
        self._model, self._robot = model, wanted.robot
        self._through = [pair for pair in pairs if pair[0].transmitted]
        self._behind = [pair for pair in pairs if not pair[0].transmitted]
        self.effects = tuple(dict.fromkeys(name_of(effect) for effect, _ in pairs))
        self.temperature = np.broadcast_to(np.asarray(temperature, float), (wanted.robot.dof,)).copy()
        inertia = "M" if hasattr(data, "M") else "qM"
        self._layout = Layout.of(data, (*READ, inertia))
        joints = [model.joint(name) for name in wanted.robot.joints]
        self._dofs = np.array([int(joint.dofadr[0]) for joint in joints])
        self._places = np.array([int(joint.qposadr[0]) for joint in joints])
        ends = model.M_rowadr + model.M_rownnz - 1 if inertia == "M" else model.dof_Madr
        self._diagonal = ends[self._dofs]
        self._inertia, self._library, self._states = inertia, library(), dict[int, State]()
        self._bias = np.zeros(model.nv)
        self._loaded = any(effect.needs_load for effect, _ in self._behind)
        self._dry = model.dof_frictionloss[self._dofs].copy()
        self._try(data)
        self._native = self._compiled(data)
        register(model, self, None if self._native is None else self._native.callbacks())
        if self._native is not None:
            self._native.begin()
        model.dof_frictionloss[self._dofs] = 0.0

    def _compiled(self, data: Any) -> Native | None:
        """The effects as machine code; None where an effect has no such form, or Numba is absent."""
        pairs, model = [*self._behind, *self._through], self._model
        if not possible(pairs):
            return None
        places = [self._layout.time, *(self._layout.places[name] for name in (*READ, self._inertia))]
        return Native(
            int(model._address), step_address(model), self.temperature, places,
            (self._dofs, self._places, self._diagonal), terms_of(self._robot, pairs), self._loaded, model.nv,
        )  # fmt: skip

    def _try(self, data: Any) -> None:
        """Ask all effects once, here, where what they raise is seen."""
        state = self._state(int(data._address))
        self._torque(state)
        state.torques.forget()
        state.transmitted.forget()

    def __enter__(self) -> "Attached":
        return self

    def __exit__(self, *_: object) -> None:
        self.detach()

    def detach(self) -> None:
        """Take them away; the model is as it was."""
        if self._native is not None:
            self._native.release()
        release(self._model)
        self._model.dof_frictionloss[self._dofs] = self._dry

    def passive(self, data: int) -> None:
        """Add forces; called by MuJoCo, and for a data that is new by what is compiled."""
        if self._native is not None:
            self._native.admit(data, self._layout.pointer(data, "qpos"))
            return
        state = self._state(data)
        self._go_on(state)
        torque, state.drag[:] = self._torque(state)
        state.arrays["qfrc_passive"][self._dofs] -= torque

    def control(self, data: int) -> None:
        """Make friction implicit, as inertia that a step has to speed up besides; called by MuJoCo."""
        if self._native is not None:  # after a data is new to it in `passive`
            return
        state = self._state(data)
        state.arrays[self._inertia][self._diagonal] += self._model.opt.timestep * state.drag
        self._library.mj_factorM(self._model._address, data)

    def _state(self, data: int) -> State:
        """State of the effects in the data at an address."""
        state = self._states.get(data)
        pointer = self._layout.pointer(data, "qpos")
        if state is None or state.pointer != pointer:
            arrays = {name: self._layout.array(data, name) for name in self._layout.places}
            behind, through = (Torques(self._robot, pairs) for pairs in (self._behind, self._through))
            clock, numbers = self._layout.clock(data), np.zeros((3, len(self._dofs)))
            state = State(data, behind, through, arrays, pointer, clock, [np.inf], *numbers)
            self._states[data] = state
        return state

    def _go_on(self, state: State) -> None:
        """Remember where the arm is now, once a step; after a reset, begin anew."""
        now, [last] = state.clock.value, state.last
        if now == last:
            return
        velocity = state.arrays["qvel"][self._dofs]
        if now < last:
            state.torques.forget()
            state.acceleration[:] = state.arrays["qacc"][self._dofs]
        else:  # qacc itself leaves out what an integrator makes implicit, as the damping of servos
            state.acceleration[:] = (velocity - state.velocity) / (now - last)
        state.velocity[:], state.last[0] = velocity, now
        state.torques.remember(state.arrays["qpos"][self._places])

    def _torque(self, state: State) -> Share:
        """Torque that all effects take."""
        position, velocity = state.arrays["qpos"][self._places], state.arrays["qvel"][self._dofs]
        step, load = self._model.opt.timestep, np.zeros(len(velocity))
        through = None
        if self._through:
            through = state.transmitted.at(position, velocity, step, load, self.temperature)
        if self._loaded:
            load = self._load(state) + (through.torque if through else 0.0)
        own = state.torques.at(position, velocity, step, load, self.temperature)
        return own if through is None else Share(own.torque + through.torque, own.drag + through.drag)

    def _load(self, state: State) -> np.ndarray:
        """Torque that the gears carry, at the acceleration of the step before, shape (n,) [N m].

        Where none was made to here, as in inverse dynamics, at that which is given.
        """
        arrays = state.arrays
        given = arrays["qacc"][self._dofs]
        if np.array_equal(arrays["qvel"][self._dofs], state.velocity):
            arrays["qacc"][self._dofs] = state.acceleration
        self._library.mj_rne(self._model._address, state.address, 1, self._bias.ctypes.data)
        arrays["qacc"][self._dofs] = given
        return (self._bias - arrays["qfrc_spring"] - arrays["qfrc_gravcomp"])[self._dofs]
