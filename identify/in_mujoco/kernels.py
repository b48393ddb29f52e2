"""Compiled callbacks of MuJoCo: the computations of `Attached` on the arrays that `Native` lays out."""
# Numba infers types itself, so these functions have no annotations.
# ruff: noqa: ANN001, ANN202
# mypy: ignore-errors

from ctypes import CFUNCTYPE, c_int, c_size_t, c_void_p, cast
from functools import cache
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
from numba import carray, cfunc, njit, types, uintp, void
from numba.core import cgutils
from numba.extending import intrinsic, register_jitable

from ..effects.hysteresis import slid
from .callbacks import CALLS, KIND, library
from .native import (
    BEFORE,
    CONSTANTS,
    DATA,
    FLOATS,
    INTS,
    KEYS,
    MODEL,
    MODELS,
    REMEMBERS,
    STATES,
    STEP,
    TABLE,
    TEMPERATURE,
)  # fmt: skip
from .torques import SLOWEST

_slid_here = njit(slid)
ADDRESS = TABLE.ctypes.data
_inline = njit(inline="always")
"""Inlining for the parts of one step: as calls with array arguments they would take a fifth of its time."""
COLUMNS = TABLE.shape[1]


@intrinsic
def _pointer(context, address):
    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(address), generate


@njit
def _floats(address, count):
    return carray(_pointer(address), count, np.float64)


@njit
def _integers(address, count):
    return carray(_pointer(address), count, np.int64)


@njit
def _array(data, offset, count):
    """An array of an `MjData`, whose pointer is at an offset in the struct."""
    return _floats(_integers(data + offset, 1)[0], count)


@njit
def _row_of(model):
    models = _integers(ADDRESS, MODELS * COLUMNS)
    for row in range(MODELS):
        if models[row * COLUMNS + MODEL] == model:
            return row
    return -1


@njit
def _state_of(row, data):
    """Index of the state of an `MjData`; -1 if it is new, or another one at the same address."""
    table = _integers(ADDRESS, MODELS * COLUMNS)
    ints = _integers(table[row * COLUMNS + INTS], BEFORE)
    keys = _integers(table[row * COLUMNS + KEYS], 2 * DATA)
    for slot in range(DATA):
        if keys[2 * slot] == data:
            return slot if keys[2 * slot + 1] == _integers(data + ints[5], 1)[0] else -1
        if keys[2 * slot] == 0:
            return -1
    return -1


@njit
def _size(n, size, terms):
    return 1 + 5 * n + size + terms


class Arm(NamedTuple):
    """Numbers of an arm: counts, offsets in the struct of an `MjData`, and terms."""

    table: Any
    head: Any
    dofs: Any
    qpos: Any
    codes: Any
    joints: Any
    constants: Any
    values: Any
    temperature: Any


class Memory(NamedTuple):
    """State for one `MjData`, see `State` of `Attached`; `at` and `hold` belong to hysteresis."""

    clock: Any
    velocity: Any
    acceleration: Any
    drag: Any
    at: Any
    load: Any
    bias: Any
    hold: Any


class Moving(NamedTuple):
    """Arrays of an `MjData`, over all of its degrees of freedom."""

    position: Any
    velocity: Any
    acceleration: Any
    forces: Any


@_inline
def _arm(row):
    table = _integers(ADDRESS, MODELS * COLUMNS)[row * COLUMNS : (row + 1) * COLUMNS]
    head = _integers(table[INTS], BEFORE)
    n, terms = head[0], head[1]
    ints = _integers(table[INTS], BEFORE + 3 * n + 2 * terms)
    codes, joints = ints[BEFORE + 3 * n : BEFORE + 3 * n + terms], ints[BEFORE + 3 * n + terms :]
    floats = _floats(table[FLOATS], 2 * CONSTANTS * terms)
    dofs, qpos = ints[BEFORE : BEFORE + n], ints[BEFORE + n : BEFORE + 2 * n]
    constants, values = floats[: CONSTANTS * terms], floats[CONSTANTS * terms :]
    return Arm(table, head, dofs, qpos, codes, joints, constants, values, _floats(table[TEMPERATURE], n))


@_inline
def _memory(arm, slot):
    n, terms, size = arm.head[0], arm.head[1], arm.head[3]
    length = _size(n, size, terms)
    state = _floats(arm.table[STATES] + 8 * slot * length, length)
    arrays = state[1:]
    return Memory(
        state[:1], arrays[:n], arrays[n : 2 * n], arrays[2 * n : 3 * n], arrays[3 * n : 4 * n],
        arrays[4 * n : 5 * n], arrays[5 * n : 5 * n + size], arrays[5 * n + size :],
    )  # fmt: skip


@_inline
def _moving(arm, data):
    head, size = arm.head, arm.head[3]
    return Moving(
        _array(data, head[5], 1 + size * 2), _array(data, head[6], size), _array(data, head[7], size),
        _array(data, head[8], size),
    )  # fmt: skip


@_inline
def _update(arm, memory, moving, now):
    """Store the current motion; start over after a reset."""
    last = memory.clock[0]
    reset = now < last
    for j in range(len(arm.dofs)):
        v = moving.velocity[arm.dofs[j]]
        memory.acceleration[j] = (
            moving.acceleration[arm.dofs[j]] if reset else (v - memory.velocity[j]) / (now - last)
        )
        memory.velocity[j] = v
    for k in range(len(arm.codes)):
        if arm.codes[k] == REMEMBERS:
            j = arm.joints[k]
            displacement = moving.position[arm.qpos[j]] - memory.at[j]
            memory.hold[k] = (
                0.0 if reset else _slid_here(memory.hold[k], displacement, arm.constants[CONSTANTS * k])
            )
    for j in range(len(arm.dofs)):
        memory.at[j] = moving.position[arm.qpos[j]]
    memory.clock[0] = now


@_inline
def _update_load(arm, memory, moving, model, data, slot, rne):
    """Compute the torque that the gears transmit, at the preceding step's acceleration or else at `qacc`."""
    unchanged = True
    for j in range(len(arm.dofs)):
        unchanged = unchanged and moving.velocity[arm.dofs[j]] == memory.velocity[j]
    for j in range(len(arm.dofs)):
        memory.load[j] = moving.acceleration[arm.dofs[j]]
        if unchanged:
            moving.acceleration[arm.dofs[j]] = memory.acceleration[j]
    n, terms, size = arm.head[0], arm.head[1], arm.head[3]
    rne(model, data, 1, arm.table[STATES] + 8 * (slot * _size(n, size, terms) + 1 + 5 * n))
    spring, gravity_compensation = _array(data, arm.head[9], size), _array(data, arm.head[10], size)
    for j in range(n):
        dof = arm.dofs[j]
        moving.acceleration[dof] = memory.load[j]
        memory.load[j] = memory.bias[dof] - spring[dof] - gravity_compensation[dof]


def _kernels(torque, rne, factor):
    """Functions for passive and control forces, for a row of the table and the index of a state."""

    @_inline
    def add(arm, memory, moving, step, k):
        """Subtract the torque of a term, which is linear in velocity over this step."""
        j = arm.joints[k]
        v, q = moving.velocity[arm.dofs[j]], moving.position[arm.qpos[j]]
        speed = v if abs(v) >= SLOWEST else SLOWEST
        place = CONSTANTS * k
        constants = (arm.constants[place], arm.constants[place + 1], arm.constants[place + 2])
        first, second = arm.values[place], arm.values[place + 1]
        if arm.codes[k] == REMEMBERS:
            here = _slid_here(memory.hold[k], q - memory.at[j], constants[0])
            at_rest, in_motion = first * here, first * _slid_here(here, step * speed, constants[0])
        else:
            load, temperature = memory.load[j], arm.temperature[j]
            at_rest = torque(arm.codes[k], first, second, q, 0.0, load, temperature, constants)
            in_motion = torque(arm.codes[k], first, second, q, speed, load, temperature, constants)
        secant = (in_motion - at_rest) / speed
        moving.forces[arm.dofs[j]] -= at_rest + secant * v
        memory.drag[j] += secant

    @njit
    def passive(row, slot, model, data):
        arm = _arm(row)
        memory, moving, now = _memory(arm, slot), _moving(arm, data), _floats(data + arm.head[4], 1)[0]
        if now != memory.clock[0]:
            _update(arm, memory, moving, now)
        if arm.head[2]:
            _update_load(arm, memory, moving, model, data, slot, rne)
        memory.drag[:] = 0.0
        for k in range(len(arm.codes)):
            add(arm, memory, moving, _floats(arm.table[STEP], 1)[0], k)
        for j in range(len(memory.drag)):
            memory.drag[j] = max(memory.drag[j], 0.0)

    @njit
    def control(row, slot, model, data):
        arm = _arm(row)
        memory, step = _memory(arm, slot), _floats(arm.table[STEP], 1)[0]
        ints, pointer = (
            _integers(arm.table[INTS], BEFORE + 3 * arm.head[0]),
            _integers(data + arm.head[11], 1)[0],
        )
        for j in range(len(memory.drag)):
            diagonal = ints[BEFORE + 2 * arm.head[0] + j]
            _floats(pointer + 8 * diagonal, 1)[0] += step * memory.drag[j]
        factor(model, data)

    return passive, control


def _dispatch(code, function, otherwise):
    """Torque by a function for terms with its code, and by `otherwise` for all others."""

    @njit
    def torque(term_code, first, second, position, velocity, load, temperature, constants):
        if term_code != code:
            return otherwise(term_code, first, second, position, velocity, load, temperature, constants)
        profiles = function(position, velocity, load, temperature, constants)
        total = first * profiles[0]
        if len(profiles) > 1:
            total += second * profiles[-1]
        return total

    return torque


@njit
def _none(term_code, first, second, position, velocity, load, temperature, constants):
    return 0.0


@cache
def _jitable(function):
    """A formula, after registering the functions that it calls for compilation."""
    for name in function.__code__.co_names:
        called = function.__globals__.get(name)
        if isinstance(called, FunctionType):
            register_jitable(_jitable(called))
    return function


@cache
def compiled(functions):
    """Callbacks by name for arms whose terms use these functions; Python handles other arms and new data."""
    torque = _none
    for code, function in enumerate(functions):
        torque = _dispatch(code, njit(_jitable(function)), torque)
    return {
        name: _callback(kernel, CALLS[name])
        for name, kernel in zip(("passive", "control"), _kernels(torque, *_mujoco_functions()), strict=True)
    }


def _mujoco_functions():
    """MuJoCo's mj_rne and mj_factorM, called without holding Python's lock."""
    kinds = {"mj_rne": (c_size_t, c_size_t, c_int, c_size_t), "mj_factorM": (c_size_t, c_size_t)}
    return [
        CFUNCTYPE(None, *kind)(cast(getattr(library(), name), c_void_p).value) for name, kind in kinds.items()
    ]


def _callback(kernel, fallback):
    """A kernel as a C callback, with a Python callback as its fallback."""
    python = CFUNCTYPE(None, c_size_t, c_size_t)(cast(fallback, c_void_p).value)

    @cfunc(void(uintp, uintp))
    def call(model, data):
        row = _row_of(model)
        if row < 0:
            python(model, data)
            return
        slot = _state_of(row, data)
        if slot < 0:
            python(model, data)
            slot = _state_of(row, data)
        if slot >= 0:
            kernel(row, slot, model, data)

    callback = KIND(call.address)
    callback.compiled = call  # keeps the machine code alive
    return callback
