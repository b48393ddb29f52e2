"""Compiled callbacks of MuJoCo: what `Attached` does in a step, on the numbers that `Native` lays out."""
# Numba takes these functions apart, and has types of its own.
# ruff: noqa: ANN001, ANN202
# mypy: ignore-errors

from ctypes import CFUNCTYPE, c_int, c_size_t, c_void_p, cast
from functools import cache
from types import FunctionType

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

ADDRESS = TABLE.ctypes.data
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


def _kernels(torque, rne, factor):
    """What passive and control forces are, for a row of the table and a place of a state."""
    slid_here = njit(slid)

    @njit
    def passive(row, place, model, data):
        table = _whole(ADDRESS, MODELS * COLUMNS)[row * COLUMNS : (row + 1) * COLUMNS]
        head = _whole(table[INTS], BEFORE)
        n, terms, loaded, size = head[0], head[1], head[2], head[3]
        ints = _whole(table[INTS], BEFORE + 3 * n + 2 * terms)
        dofs, places = ints[BEFORE : BEFORE + n], ints[BEFORE + n : BEFORE + 2 * n]
        codes, joints = ints[BEFORE + 3 * n :], ints[BEFORE + 3 * n + terms :]
        floats = _numbers(table[FLOATS], 2 * CONSTANTS * terms)
        values = floats[CONSTANTS * terms :]
        length = _size(n, size, terms)
        state = _numbers(table[STATES] + 8 * place * length, length)
        before, speed, drag = state[1 : 1 + n], state[1 + n : 1 + 2 * n], state[1 + 2 * n : 1 + 3 * n]
        at, load = state[1 + 3 * n : 1 + 4 * n], state[1 + 4 * n : 1 + 5 * n]
        bias, memory = state[1 + 5 * n :], state[1 + 5 * n + size :]
        temperature, step = _numbers(table[TEMPERATURE], n), _numbers(table[STEP], 1)[0]
        position, velocity = _array(data, head[5], 1 + size * 2), _array(data, head[6], size)
        acceleration, forces = _array(data, head[7], size), _array(data, head[8], size)
        now = _numbers(data + head[4], 1)[0]
        if now != state[0]:
            again = now < state[0]
            for j in range(n):
                v = velocity[dofs[j]]
                speed[j] = acceleration[dofs[j]] if again else (v - before[j]) / (now - state[0])
                before[j] = v
            for k in range(terms):
                if codes[k] == REMEMBERS:
                    j = joints[k]
                    way = position[places[j]] - at[j]
                    memory[k] = 0.0 if again else slid_here(memory[k], way, floats[CONSTANTS * k])
            for j in range(n):
                at[j] = position[places[j]]
            state[0] = now
        if loaded:
            same = True
            for j in range(n):
                same = same and velocity[dofs[j]] == before[j]
            for j in range(n):
                load[j] = acceleration[dofs[j]]
                if same:
                    acceleration[dofs[j]] = speed[j]
            rne(model, data, 1, table[STATES] + 8 * (place * length + 1 + 5 * n))
            spring, carried = _array(data, head[9], size), _array(data, head[10], size)
            for j in range(n):
                acceleration[dofs[j]] = load[j]
                load[j] = bias[dofs[j]] - spring[dofs[j]] - carried[dofs[j]]
        for j in range(n):
            drag[j] = 0.0
        for k in range(terms):
            j = joints[k]
            v, q = velocity[dofs[j]], position[places[j]]
            moving = v if abs(v) >= SLOWEST else SLOWEST
            constants = (floats[CONSTANTS * k], floats[CONSTANTS * k + 1])
            first, second = values[CONSTANTS * k], values[CONSTANTS * k + 1]
            if codes[k] == REMEMBERS:
                way = q - at[j]
                here = slid_here(memory[k], way, constants[0])
                rest = first * here
                there = first * slid_here(here, step * moving, constants[0])
            else:
                rest = torque(codes[k], first, second, q, 0.0, load[j], temperature[j], constants)
                there = torque(codes[k], first, second, q, moving, load[j], temperature[j], constants)
            secant = (there - rest) / moving
            forces[dofs[j]] -= rest + secant * v
            drag[j] += secant
        for j in range(n):
            drag[j] = max(drag[j], 0.0)

    @njit
    def control(row, place, model, data):
        table = _whole(ADDRESS, MODELS * COLUMNS)[row * COLUMNS : (row + 1) * COLUMNS]
        head = _whole(table[INTS], BEFORE)
        n, terms, size = head[0], head[1], head[3]
        ints = _whole(table[INTS], BEFORE + 3 * n)
        length = _size(n, size, terms)
        drag = _numbers(table[STATES] + 8 * (place * length + 1 + 2 * n), n)
        step, pointer = _numbers(table[STEP], 1)[0], _whole(data + head[11], 1)[0]
        for j in range(n):
            _numbers(pointer + 8 * ints[BEFORE + 2 * n + j], 1)[0] += step * drag[j]
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
