"""Effects compiled by Numba for MuJoCo's steps, which run without Python and do not wait for its lock.

The formulas are the effects' own functions, compiled for single numbers; they are applied as `Torques` and
`Attached` do. The numbers of an arm and of each of its `MjData` lie in arrays that are found by address;
Python is called once for each new `MjData`.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..effects import EFFECTS, Effect, Hysteresis, JointEffect

MODELS, DATA = 64, 1024
"""Maximum number of models at a time, and of `MjData` of each: a rollout uses one per thread."""
CONSTANTS = 3
"""Maximum number of constants and of profiles in a formula."""
REMEMBERS = -1
"""Code of a term with hysteresis; the code of any other term is the index of its function."""
MODEL, INTS, FLOATS, KEYS, STATES, STEP, TEMPERATURE = range(7)
"""Columns of the table of models; each holds an address."""
BEFORE = 12
"""Number of integers before those of the joints: counts, then offsets in the struct of an `MjData`."""

TABLE = np.zeros((MODELS, 7), np.int64)
"""One row for each model with compiled effects; the address of the model is zero in a free row."""


class Terms(NamedTuple):
    """Joint torques, one row for each joint of each effect.

    Attributes:
        code: Index of the function, or `REMEMBERS`, shape (k,).
        joint: Index of the joint, shape (k,).
        constants: Constants of the formula, shape (k, 2).
        values: Parameter values, shape (k, 2).
    """

    code: np.ndarray
    joint: np.ndarray
    constants: np.ndarray
    values: np.ndarray


FUNCTIONS: list[Callable[..., Any]] = list(
    dict.fromkeys(
        form.function
        for kind in EFFECTS.values()
        if issubclass(kind, JointEffect) and (form := kind().formula) is not None
    )
)
"""Functions of the profiles; a code is an index into them. New functions are appended, since all are compiled
together, once per process."""


def possible(effects: Sequence[tuple[Effect, np.ndarray]]) -> bool:
    """Whether all effects can be compiled, Numba is available, and the table has room for another arm."""
    room = bool(np.any(TABLE[:, MODEL] == 0))
    return room and all(_has_form(effect) for effect, _ in effects) and _numba()


def _has_form(effect: Effect) -> bool:
    if not isinstance(effect, JointEffect) or effect.transmitted:
        return False
    if isinstance(effect, Hysteresis):
        return True
    return effect.formula is not None and len(effect.formula.constants) <= CONSTANTS


def terms_of(robot: Robot, effects: Sequence[tuple[Effect, np.ndarray]]) -> Terms:
    """Terms of effects with their parameters (p,); new functions are appended to `FUNCTIONS`."""
    rows: list[tuple[int, int, tuple[float, ...], np.ndarray]] = []
    for effect, values in effects:
        assert isinstance(effect, JointEffect)
        columns, constants = effect.columns(robot), tuple[float, ...]()
        if isinstance(effect, Hysteresis):
            code, constants = REMEMBERS, (effect.presliding,)
        else:
            assert effect.formula is not None
            function, constants = effect.formula
            if function not in FUNCTIONS:
                FUNCTIONS.append(function)
            code = FUNCTIONS.index(function)
        per_joint = values.reshape(len(columns), -1)
        rows += [(code, joint, constants, row) for joint, row in zip(columns, per_joint, strict=True)]
    terms = Terms(*(np.zeros(len(rows), np.int64) for _ in range(2)), *np.zeros((2, len(rows), CONSTANTS)))
    for index, (code, joint, constants, parameters) in enumerate(rows):
        terms.code[index], terms.joint[index] = code, joint
        terms.constants[index, : len(constants)] = constants
        terms.values[index, : len(parameters)] = parameters
    return terms


class Native:
    """The numbers of an arm, laid out for compiled callbacks.

    Args:
        model: Address of the `MjModel`.
        step: Address of its time step.
        temperature: Joint temperature, shape (n,) [degC], read in every step.
        places: Offsets in the struct of an `MjData` [byte], in the order in which `_kernels` reads them.
        addresses: Indices of each joint in the velocities, in the positions and of its diagonal element in
            the inertia, each (n,).
        terms: Terms of the effects.
        loaded: Whether any effect depends on load.
        size: Number of degrees of freedom of the model.
    """

    def __init__(
        self, model: int, step: int, temperature: np.ndarray, places: Sequence[int],
        addresses: Sequence[np.ndarray], terms: Terms, loaded: bool, size: int,
    ) -> None:  # fmt: skip
        joints, count = len(addresses[0]), len(terms.code)
        head = np.zeros(BEFORE, np.int64)
        head[:4], head[4 : 4 + len(places)] = (joints, count, loaded, size), places
        self._ints = np.concatenate([head, *addresses, terms.code, terms.joint]).astype(np.int64)
        self._floats = np.concatenate([terms.constants.ravel(), terms.values.ravel()])
        self._keys = np.zeros((DATA, 2), np.int64)
        self._states = np.zeros((DATA, 1 + 5 * joints + size + count))
        self._next, self._temperature = 0, temperature
        arrays = (self._ints, self._floats, self._keys, self._states)
        self._entry = model, *(a.ctypes.data for a in arrays), step, temperature.ctypes.data

    def begin(self) -> None:
        """Enter the arm into the table, where compiled callbacks find it until `release`."""
        self._row = int(np.flatnonzero(TABLE[:, MODEL] == 0)[0])
        TABLE[self._row] = self._entry

    def admit(self, data: int, pointer: int) -> None:
        """Reserve a state for an `MjData` at an address, whose positions are at another address."""
        known = np.flatnonzero(self._keys[:, 0] == data)
        row = int(known[0]) if len(known) else self._next
        self._next = (self._next + (not len(known))) % DATA
        # The key is written last, because other threads search the keys meanwhile.
        self._states[row], self._states[row, 0] = 0.0, np.inf
        self._keys[row, 1] = pointer
        self._keys[row, 0] = data

    def callbacks(self) -> dict[str, Any]:
        """Compiled callbacks by name, for all functions."""
        from .kernels import compiled  # imports Numba, which takes half a second

        return dict(compiled(tuple(FUNCTIONS)))

    def release(self) -> None:
        """Remove the arm from the table."""
        TABLE[self._row] = 0


def _numba() -> bool:
    """Whether Numba is installed and its compiler is enabled."""
    try:
        import numba
    except ImportError:  # missing, or built for another NumPy
        return False
    return not getattr(numba.config, "DISABLE_JIT", False)
