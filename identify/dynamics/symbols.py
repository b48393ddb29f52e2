"""Symbols: scalars that record the operations applied to them, so that these can be written as a program.

A formula that is called with symbols leaves one step for each operation on a `Tape`. Operations with known
result (0 times x, 1 times x, x minus x) leave none, and the same operation is recorded only once.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

UNARY = ("negative", "absolute", "sign", "sqrt", "exp", "log", "sin", "cos", "tanh", "arctan", "sinh", "cosh")
BINARY = ("add", "subtract", "multiply", "divide", "power", "hypot", "maximum", "minimum")
OPERATIONS = {getattr(np, name): name for name in (*UNARY, *BINARY)}
"""NumPy function -> operation of a step."""
COMMUTES = ("add", "multiply", "hypot", "maximum", "minimum")


class Step(NamedTuple):
    """One step of a program: an operation with its arguments, numbers or indices of earlier steps."""

    operation: str  # name in `UNARY` or `BINARY`, or "input"
    arguments: tuple[Any, ...]  # numbers as float, earlier steps as int; of an input its name and its place


class Tape:
    """Steps of a program, in their order."""

    def __init__(self) -> None:
        self.steps: list[Step] = []
        self._places: dict[tuple[Any, ...], int] = {}

    def inputs(self, name: str, count: int) -> "list[Symbol]":
        """Symbols of the elements of an input array."""
        return [self.record("input", name, place) for place in range(count)]

    def record(self, operation: str, *arguments: Any) -> "Symbol":
        """Symbol of a step, which is appended if it is new."""
        if operation in COMMUTES:
            arguments = tuple(sorted(arguments, key=lambda argument: (isinstance(argument, int), argument)))
        key = (
            operation,
            *((type(argument), argument) for argument in arguments),
        )  # the number 3.0 is no step 3
        if key not in self._places:
            self._places[key] = len(self.steps)
            self.steps.append(Step(operation, arguments))
        return Symbol(self, self._places[key])


class Symbol(NDArrayOperatorsMixin):
    """The result of a step; operators and NumPy functions record further steps.

    Args:
        tape: Tape of the step.
        index: Index of the step.
    """

    __slots__ = ("index", "tape")

    def __init__(self, tape: Tape, index: int) -> None:
        self.tape, self.index = tape, index

    def __array_ufunc__(self, function: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        name = OPERATIONS.get(function)
        if name is None or method != "__call__" or options or any(np.ndim(i) for i in inputs):
            return NotImplemented
        arguments = [i.index if isinstance(i, Symbol) else float(i) for i in inputs]
        simple = _simplified(self.tape, name, arguments)
        return self.tape.record(name, *arguments) if simple is None else simple


def _simplified(tape: Tape, name: str, arguments: Sequence[Any]) -> Any:
    """A number or symbol that equals the result of an operation; None if it is no simpler."""
    first, second = arguments[0], arguments[-1]

    def of(argument: Any) -> Any:
        return Symbol(tape, argument) if isinstance(argument, int) else argument

    def negative(argument: Any) -> Any:
        return -of(argument)

    zeros, units, negatives = (
        [isinstance(a, float) and a == value for a in arguments] for value in (0.0, 1.0, -1.0)
    )
    if name == "negative" and tape.steps[first].operation == "negative":
        return of(tape.steps[first].arguments[0])
    if name == "add" and any(zeros):
        return of(second if zeros[0] else first)
    if name == "subtract":
        if first == second and type(first) is type(second):
            return 0.0
        return of(first) if zeros[1] else negative(second) if zeros[0] else None
    if name == "multiply":
        if any(zeros):
            return 0.0
        if any(units):
            return of(second if units[0] else first)
        return negative(second if negatives[0] else first) if any(negatives) else None
    if name == "divide" and (zeros[0] or units[1]):
        return of(first)
    return None
