"""Programs: quantities of an arm recorded on a tape, as lines of a language or as a compiled function."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..effects import Effect
from ..effects.joint_state import JointState
from ..errors import FitError
from .dynamics import Dynamics
from .symbols import BINARY, UNARY, Step, Symbol, Tape

if TYPE_CHECKING:
    from ..fit.fit import Fit

LONGEST = 64
"""Longest expression of a value that is used once, before it gets a variable of its own [characters]."""
INFIX = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/"}


class Language(NamedTuple):
    """How a language writes operations."""

    functions: dict[str, str]  # operation -> name of its function, for all that are not infix
    # Function of a variable and an expression that returns the line of an assignment.
    assign: Callable[[str, str], str]


_OF_PYTHON = {
    "absolute": "abs",
    "sign": "_sign",
    "maximum": "max",
    "minimum": "min",
    "arctan": "atan",
    "power": "pow",
}
PYTHON = Language(
    {name: _OF_PYTHON.get(name, name) for name in (*UNARY, *BINARY)}, lambda name, text: f"{name} = {text}"
)
"""Python with the functions of `math` and a function `_sign`."""
MATH = "atan, cos, cosh, exp, hypot, log, sin, sinh, sqrt, tanh"
"""Functions of `math` that programs use."""


class Lines(NamedTuple):
    """Body of a function."""

    assignments: list[str]  # lines, one per variable
    results: list[str]  # expressions of the results
    inputs: list[tuple[str, int]]  # inputs that are used, as pairs of name and place


def number(value: float) -> str:
    """Literal that has all digits of a number, in Python and C++."""
    return repr(float(value))


def written(tape: Tape, results: Sequence[Any], language: Language) -> Lines:
    """Assignments and expressions of results, numbers or symbols, without steps that none of them needs."""
    indices = [result.index for result in results if isinstance(result, Symbol)]
    uses = _uses(tape, indices)
    for index in indices:
        uses[index] += 1
    texts: dict[int, str] = {}
    assignments: list[str] = []
    for index in sorted(uses):
        step = tape.steps[index]
        text = _text(step, texts, language)
        if step.operation == "input" or (uses[index] == 1 and len(text) <= LONGEST):
            texts[index] = text
            continue
        texts[index] = f"v{len(assignments)}"
        assignments.append(language.assign(texts[index], _bare(text)))
    expressions = [_bare(texts[r.index]) if isinstance(r, Symbol) else number(r) for r in results]
    inputs = sorted(tape.steps[index].arguments for index in uses if tape.steps[index].operation == "input")
    return Lines(assignments, expressions, inputs)


def _uses(tape: Tape, results: Sequence[int]) -> dict[int, int]:
    """Number of steps that use each step on which the results depend."""
    uses = dict.fromkeys(results, 0)
    for index in range(len(tape.steps) - 1, -1, -1):
        if index in uses and tape.steps[index].operation != "input":
            for argument in tape.steps[index].arguments:
                if isinstance(argument, int):
                    uses[argument] = uses.get(argument, 0) + 1
    return uses


def _bare(text: str) -> str:
    """An expression without the parentheses around all of it."""
    return text[1:-1] if text.startswith("(") else text


def _text(step: Step, texts: dict[int, str], language: Language) -> str:
    """Expression of a step, in parentheses if an operator is its outermost part."""
    if step.operation == "input":
        name, place = step.arguments
        return f"{name}{place}"
    parts = [texts[a] if isinstance(a, int) else number(a) for a in step.arguments]
    if step.operation in INFIX:
        return f"({parts[0]} {INFIX[step.operation]} {parts[1]})"
    if step.operation == "negative":
        return f"(-{parts[0]})"
    return f"{language.functions[step.operation]}({', '.join(map(_bare, parts))})"


def python_body(arguments: Sequence[str], joints: int, lines: Lines) -> list[str]:
    """Lines that give each used input a variable, and the assignments; `joints` numbers per argument."""
    body = []
    for name in arguments:
        used = [f"{name}{place}" if (name, place) in lines.inputs else "_" for place in range(joints)]
        body.append(f"{', '.join(used)}{',' * (joints == 1)} = {name}")
    return [*body, *lines.assignments]


STATE = ("q", "dq", "ddq", "load", "temperature")
"""Names of the inputs, in the order of `JointState`."""


def traced_state(joints: int) -> tuple[Tape, JointState]:
    """A tape, and a state of symbols on it."""
    tape = Tape()
    return tape, JointState(*(tape.inputs(name, joints) for name in STATE))


def compiled(
    joints: int, arguments: Sequence[str], quantities: Callable[[JointState], Sequence[Any]]
) -> Callable[..., tuple[float, ...]]:
    """A Python function of lists of numbers that computes quantities of a joint state.

    It takes some 30 ns per operation, where NumPy takes 500 ns on single numbers.

    Args:
        joints: Number of joints n.
        arguments: Names in `STATE` of the function's arguments, each with n numbers.
        quantities: Function of a state that returns scalars.
    """
    tape, state = traced_state(joints)
    lines = written(tape, quantities(state), PYTHON)
    body = [*python_body(arguments, joints, lines), f"return ({', '.join(lines.results)},)"]
    text = f"from math import {MATH}\ndef _sign(x):\n    return (x > 0.0) - (x < 0.0)\n"
    text += f"def function({', '.join(arguments)}):\n" + "".join(f"    {line}\n" for line in body)
    scope: dict[str, Any] = {}
    exec(text, scope)  # numbers and names of variables only, see `program`
    function: Callable[..., tuple[float, ...]] = scope["function"]
    return function


def fitted_dynamics(fit: "Fit", payload: str = "") -> Dynamics:
    """Dynamics of a fit while the named payload is carried, see `writable`.

    Raises:
        FitError: The fit has no such payload.
    """
    model = fit.model
    if payload and payload not in model.payloads:
        names = ", ".join(model.payloads) or "none"
        raise FitError(f"{model.robot.name}: no payload '{payload}'. Payloads of the fit: {names}")
    values = np.zeros(len(model.names))
    values[fit.base.kept] = fit.estimate.values
    return writable(Dynamics.of(model, values, payload))


def writable(dynamics: Dynamics) -> Dynamics:
    """The dynamics in which effects whose formula cannot be written as a program are left out."""
    pairs = [(_writable(dynamics.robot, *pair), pair) for pair in dynamics.effects]
    if all(possible for possible, _ in pairs):
        return dynamics
    left_out = (*dynamics.left_out, *(pair for possible, pair in pairs if not possible))
    return replace(dynamics, effects=tuple(pair for possible, pair in pairs if possible), left_out=left_out)


def _writable(robot: Robot, effect: Effect, values: np.ndarray) -> bool:
    """Whether symbols can pass through an effect's formula: it compares none and calls known functions."""
    _, state = traced_state(robot.dof)
    try:
        return effect.joint_torque(robot, values, state) is not None
    except (TypeError, ValueError, AttributeError):  # what NumPy and Python raise for an unknown operation
        return False
