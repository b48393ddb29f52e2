"""Effects as machine code in MuJoCo's steps, by Numba: Python is not asked, and threads need not wait for it.

The formulas are the effects' own functions, compiled for single numbers; what is done with them is what
`Torques` and `Attached` do. Numbers of an arm, and of each of its data, lie in arrays that are found by
addresses; a data that is new is told to Python once.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..effects import EFFECTS, Effect, Hysteresis, JointEffect

MODELS, DATA = 64, 1024
"""Models at a time, and data of one: those of rollouts are as many as threads."""
CONSTANTS = 2
"""Of a formula, at most; and profiles of one."""
REMEMBERS = -1
"""Code of a term with hysteresis; others are the places of their functions."""
MODEL, INTS, FLOATS, KEYS, STATES, STEP, TEMPERATURE = range(7)
"""Columns of the table of models: addresses."""
BEFORE = 12
"""Whole numbers before those of joints: counts, then places in the struct of a data."""

TABLE = np.zeros((MODELS, 7), np.int64)
"""A row a model that is stepped by machine code; the address of a model is zero where a row is free."""


class Terms(NamedTuple):
    """Torque of joints, one row a joint of an effect.

    Attributes:
        code: Place of its function, or `REMEMBERS`, shape (k,).
        joint: Shape (k,).
        constants: Shape (k, 2).
        values: Of its parameters, shape (k, 2).
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
"""Of profiles; a code is a place among them. What is not here at first is put behind them: all are compiled
together, once a process."""


def possible(effects: Sequence[tuple[Effect, np.ndarray]]) -> bool:
    """Whether all effects have a form that can be compiled, Numba is there, and room for one more arm."""
    room = bool(np.any(TABLE[:, MODEL] == 0))
    return room and all(_has_form(effect) for effect, _ in effects) and _numba()


def _has_form(effect: Effect) -> bool:
    if not isinstance(effect, JointEffect) or effect.transmitted:
        return False
    if isinstance(effect, Hysteresis):
        return True
    return effect.formula is not None and len(effect.formula.constants) <= CONSTANTS


def terms_of(robot: Robot, effects: Sequence[tuple[Effect, np.ndarray]]) -> Terms:
    """The rows of effects with their parameters (p,); functions that are new are put to the others."""
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
        own = values.reshape(len(columns), -1)
        rows += [(code, joint, constants, one) for joint, one in zip(columns, own, strict=True)]
    made = Terms(*(np.zeros(len(rows), np.int64) for _ in range(2)), *np.zeros((2, len(rows), CONSTANTS)))
    for row, (code, joint, constants, own) in enumerate(rows):
        made.code[row], made.joint[row] = code, joint
        made.constants[row, : len(constants)], made.values[row, : len(own)] = constants, own
    return made


class Native:
    """An arm's numbers where compiled callbacks find them.

    Args:
        model: Address of MuJoCo's model.
        step: Address of its time step.
        temperature: Of the joints, shape (n,) [degC], read in every step.
        places: In the struct of a data [byte], in the order that `_kernels` reads.
        addresses: Of each joint in velocities, in positions, and of its diagonal in the inertia, each (n,).
        terms: What acts.
        loaded: Whether any of it depends on load.
        size: Count of the model's velocities.
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
        """Have it found by compiled callbacks, from now on and until `release`."""
        self._row = int(np.flatnonzero(TABLE[:, MODEL] == 0)[0])
        TABLE[self._row] = self._entry

    def admit(self, data: int, pointer: int) -> None:
        """Give a data of the model a place, at an address and with positions at a pointer."""
        known = np.flatnonzero(self._keys[:, 0] == data)
        row = int(known[0]) if len(known) else self._next
        self._next = (self._next + (not len(known))) % DATA
        # Its key comes last: other threads look through the keys meanwhile.
        self._states[row], self._states[row, 0] = 0.0, np.inf
        self._keys[row, 1] = pointer
        self._keys[row, 0] = data

    def callbacks(self) -> dict[str, Any]:
        """What MuJoCo is to call, for all functions that there are."""
        from .kernels import compiled  # Numba, and half a second: only who steps an arm needs it

        return dict(compiled(tuple(FUNCTIONS)))

    def release(self) -> None:
        """Have it found no more."""
        TABLE[self._row] = 0


def _numba() -> bool:
    """Whether Numba is installed, and compiles."""
    try:
        import numba
    except ImportError:  # absent, or made for another NumPy
        return False
    return not getattr(numba.config, "DISABLE_JIT", False)
