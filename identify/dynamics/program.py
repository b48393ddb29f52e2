"""Programs: the steps of a tape as expressions and assignments of a language."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from .symbols import BINARY, UNARY, Step, Symbol, Tape

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
