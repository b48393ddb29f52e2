"""Compiled callbacks of MuJoCo: what `Attached` does in a step, on the numbers that `Native` lays out."""
# Numba takes these functions apart, and has types of its own.
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
"""Parts of one step: as calls, with their arrays, they take a fifth of it."""
COLUMNS = TABLE.shape[1]


@intrinsic
def _pointer(context, address):
    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(address), generate


@njit
def _numbers(address, count):
    return carray(_pointer(address), count, np.float64)


@njit
def _whole(address, count):
    return carray(_pointer(address), count, np.int64)


@njit
def _array(data, place, count):
    """An array of the data whose pointer is at a place in its struct."""
    return _numbers(_whole(data + place, 1)[0], count)


@njit
def _row_of(model):
    models = _whole(ADDRESS, MODELS * COLUMNS)
    for row in range(MODELS):
        if models[row * COLUMNS + MODEL] == model:
            return row
    return -1


@njit
def _state_of(row, data):
    """Place of a data's state; -1 for one that is new, or another at the same address."""
    table = _whole(ADDRESS, MODELS * COLUMNS)
    ints, keys = _whole(table[row * COLUMNS + INTS], BEFORE), _whole(table[row * COLUMNS + KEYS], 2 * DATA)
    for place in range(DATA):
        if keys[2 * place] == data:
            return place if keys[2 * place + 1] == _whole(data + ints[5], 1)[0] else -1
        if keys[2 * place] == 0:
            return -1
    return -1


@njit
def _size(n, size, terms):
    return 1 + 5 * n + size + terms


class Arm(NamedTuple):
    """What is known of an arm: counts, places in the struct of a data, and terms."""

    table: Any
    head: Any
    dofs: Any
    places: Any
    codes: Any
    joints: Any
    constants: Any
    values: Any
    temperature: Any


class Memory(NamedTuple):
    """What is kept of one of its data: see `State` of `Attached`; `at` and `hold` are hysteresis'."""

    clock: Any
    before: Any
    speed: Any
    drag: Any
    at: Any
    load: Any
    bias: Any
    hold: Any


class Moving(NamedTuple):
    """Arrays of a data, over all of its degrees of freedom."""

    position: Any
    velocity: Any
    acceleration: Any
    forces: Any


@_inline
def _arm(row):
    table = _whole(ADDRESS, MODELS * COLUMNS)[row * COLUMNS : (row + 1) * COLUMNS]
    head = _whole(table[INTS], BEFORE)
    n, terms = head[0], head[1]
    ints = _whole(table[INTS], BEFORE + 3 * n + 2 * terms)
    codes, joints = ints[BEFORE + 3 * n : BEFORE + 3 * n + terms], ints[BEFORE + 3 * n + terms :]
    floats = _numbers(table[FLOATS], 2 * CONSTANTS * terms)
    dofs, places = ints[BEFORE : BEFORE + n], ints[BEFORE + n : BEFORE + 2 * n]
    constants, values = floats[: CONSTANTS * terms], floats[CONSTANTS * terms :]
    return Arm(table, head, dofs, places, codes, joints, constants, values, _numbers(table[TEMPERATURE], n))


@_inline
def _memory(arm, place):
    n, terms, size = arm.head[0], arm.head[1], arm.head[3]
    length = _size(n, size, terms)
    state = _numbers(arm.table[STATES] + 8 * place * length, length)
    kept = state[1:]
    return Memory(
        state[:1], kept[:n], kept[n : 2 * n], kept[2 * n : 3 * n], kept[3 * n : 4 * n], kept[4 * n : 5 * n],
        kept[5 * n : 5 * n + size], kept[5 * n + size :],
    )  # fmt: skip


@_inline
def _moving(arm, data):
    head, size = arm.head, arm.head[3]
    return Moving(
        _array(data, head[5], 1 + size * 2), _array(data, head[6], size), _array(data, head[7], size),
        _array(data, head[8], size),
    )  # fmt: skip


@_inline
def _go_on(arm, memory, moving, now):
    """Remember where the arm is now; after a reset, begin anew."""
    last = memory.clock[0]
    again = now < last
    for j in range(len(arm.dofs)):
        v = moving.velocity[arm.dofs[j]]
        memory.speed[j] = moving.acceleration[arm.dofs[j]] if again else (v - memory.before[j]) / (now - last)
        memory.before[j] = v
    for k in range(len(arm.codes)):
        if arm.codes[k] == REMEMBERS:
            j = arm.joints[k]
            way = moving.position[arm.places[j]] - memory.at[j]
            memory.hold[k] = 0.0 if again else _slid_here(memory.hold[k], way, arm.constants[CONSTANTS * k])
    for j in range(len(arm.dofs)):
        memory.at[j] = moving.position[arm.places[j]]
    memory.clock[0] = now


@_inline
def _carry(arm, memory, moving, model, data, place, rne):
    """Torque that the gears carry, at the acceleration of the step before, or else as it is given."""
    same = True
    for j in range(len(arm.dofs)):
        same = same and moving.velocity[arm.dofs[j]] == memory.before[j]
    for j in range(len(arm.dofs)):
        memory.load[j] = moving.acceleration[arm.dofs[j]]
        if same:
            moving.acceleration[arm.dofs[j]] = memory.speed[j]
    n, terms, size = arm.head[0], arm.head[1], arm.head[3]
    rne(model, data, 1, arm.table[STATES] + 8 * (place * _size(n, size, terms) + 1 + 5 * n))
    spring, carried = _array(data, arm.head[9], size), _array(data, arm.head[10], size)
    for j in range(n):
        dof = arm.dofs[j]
        moving.acceleration[dof] = memory.load[j]
        memory.load[j] = memory.bias[dof] - spring[dof] - carried[dof]


def _kernels(torque, rne, factor):
    """What passive and control forces are, for a row of the table and a place of a state."""

    @_inline
    def add(arm, memory, moving, step, k):
        """Take the torque of a term, which is linear in speed over this step."""
        j = arm.joints[k]
        v, q = moving.velocity[arm.dofs[j]], moving.position[arm.places[j]]
        speed = v if abs(v) >= SLOWEST else SLOWEST
        constants = (arm.constants[CONSTANTS * k], arm.constants[CONSTANTS * k + 1])
        first, second = arm.values[CONSTANTS * k], arm.values[CONSTANTS * k + 1]
        if arm.codes[k] == REMEMBERS:
            here = _slid_here(memory.hold[k], q - memory.at[j], constants[0])
            rest, there = first * here, first * _slid_here(here, step * speed, constants[0])
        else:
            load, warmth = memory.load[j], arm.temperature[j]
            rest = torque(arm.codes[k], first, second, q, 0.0, load, warmth, constants)
            there = torque(arm.codes[k], first, second, q, speed, load, warmth, constants)
        secant = (there - rest) / speed
        moving.forces[arm.dofs[j]] -= rest + secant * v
        memory.drag[j] += secant

    @njit
    def passive(row, place, model, data):
        arm = _arm(row)
        memory, moving, now = _memory(arm, place), _moving(arm, data), _numbers(data + arm.head[4], 1)[0]
        if now != memory.clock[0]:
            _go_on(arm, memory, moving, now)
        if arm.head[2]:
            _carry(arm, memory, moving, model, data, place, rne)
        memory.drag[:] = 0.0
        for k in range(len(arm.codes)):
            add(arm, memory, moving, _numbers(arm.table[STEP], 1)[0], k)
        for j in range(len(memory.drag)):
            memory.drag[j] = max(memory.drag[j], 0.0)

    @njit
    def control(row, place, model, data):
        arm = _arm(row)
        memory, step = _memory(arm, place), _numbers(arm.table[STEP], 1)[0]
        ints, pointer = _whole(arm.table[INTS], BEFORE + 3 * arm.head[0]), _whole(data + arm.head[11], 1)[0]
        for j in range(len(memory.drag)):
            diagonal = ints[BEFORE + 2 * arm.head[0] + j]
            _numbers(pointer + 8 * diagonal, 1)[0] += step * memory.drag[j]
        factor(model, data)

    return passive, control


def _or(code, function, rest):
    """A term's torque where its code is that of a function, else that of the rest."""

    @njit
    def torque(which, first, second, position, velocity, load, temperature, constants):
        if which != code:
            return rest(which, first, second, position, velocity, load, temperature, constants)
        profiles = function(position, velocity, load, temperature, constants)
        total = first * profiles[0]
        if len(profiles) > 1:
            total += second * profiles[-1]
        return total

    return torque


@njit
def _none(which, first, second, position, velocity, load, temperature, constants):
    return 0.0


@cache
def _jitable(function):
    """A formula with the functions that it calls, each to be compiled with it."""
    for name in function.__code__.co_names:
        called = function.__globals__.get(name)
        if isinstance(called, FunctionType):
            register_jitable(_jitable(called))
    return function


@cache
def compiled(functions):
    """Callbacks for arms whose terms have these functions, by name; others are Python's, as are new data."""
    torque = _none
    for code, function in enumerate(functions):
        torque = _or(code, njit(_jitable(function)), torque)
    return {
        name: _callback(kernel, CALLS[name])
        for name, kernel in zip(("passive", "control"), _kernels(torque, *_of_mujoco()), strict=True)
    }


def _of_mujoco():
    """Two of its functions, called without Python's lock."""
    kinds = {"mj_rne": (c_size_t, c_size_t, c_int, c_size_t), "mj_factorM": (c_size_t, c_size_t)}
    return [
        CFUNCTYPE(None, *kind)(cast(getattr(library(), name), c_void_p).value) for name, kind in kinds.items()
    ]


def _callback(kernel, told):
    """A kernel as MuJoCo calls it."""
    python = CFUNCTYPE(None, c_size_t, c_size_t)(cast(told, c_void_p).value)

    @cfunc(void(uintp, uintp))
    def call(model, data):
        row = _row_of(model)
        if row < 0:
            python(model, data)
            return
        place = _state_of(row, data)
        if place < 0:
            python(model, data)
            place = _state_of(row, data)
        if place >= 0:
            kernel(row, place, model, data)

    made = KIND(call.address)
    made.kept = call
    return made
