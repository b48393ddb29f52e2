"""Symbols: what is recorded, what is simplified, and what the written program computes."""

import math

import numpy as np
import pytest

from exidyn.identification.dynamics.program import PYTHON, written
from exidyn.identification.dynamics.symbols import Symbol, Tape


def run(results, tape, **inputs):
    """Results of the written program, by Python."""
    lines = written(tape, results, PYTHON)
    scope = {name: getattr(math, name) for name in dir(math)}
    scope |= {f"{name}{k}": value for name, values in inputs.items() for k, value in enumerate(values)}
    scope["_sign"] = lambda x: (x > 0.0) - (x < 0.0)
    exec("\n".join(lines.assignments), scope)
    return [eval(result, scope) for result in lines.results]


@pytest.mark.parametrize(
    "formula",
    [
        lambda x, y: x + y - x * y / 3.0,
        lambda x, y: 2.0 - x,
        lambda x, y: 1.0 / (y + 5.0),
        lambda x, y: -(x - y) * np.float64(2.0),
        lambda x, y: np.float64(2.0) * x + np.float64(1.0),
        lambda x, y: np.tanh(x / 0.1) * np.exp(-((y / 0.3) ** 2)),
        lambda x, y: np.hypot(x, y) + np.abs(x) ** 0.7 * np.sign(x),
        lambda x, y: np.maximum(x, 0.1) + np.minimum(y, x) + np.sqrt(np.abs(y)) + abs(x),
        lambda x, y: sum(k * np.cos(k * x) + np.sin(y) for k in range(1, 3)),
    ],
)
def test_a_program_computes_what_numpy_computes(formula):
    tape, (x, y) = Tape(), (0.37, -1.2)
    [a, b] = tape.inputs("q", 2)
    assert run([formula(a, b)], tape, q=(x, y)) == pytest.approx([formula(x, y)], rel=1e-15)


def test_known_results_leave_no_step():
    tape = Tape()
    [x] = tape.inputs("q", 1)
    for zero in (0.0 * x, x * 0.0, x - x, 0.0 / x):
        assert zero == 0.0
    for same in (1.0 * x, x + 0.0, 0.0 + x, x - 0.0, x / 1.0, -np.negative(x)):
        assert isinstance(same, Symbol)
        assert same.index == x.index
    assert [step.operation for step in tape.steps] == ["input", "negative"]


def test_an_operation_is_recorded_once():
    tape = Tape()
    [x, y] = tape.inputs("q", 2)
    assert (x * y).index == (y * x).index
    assert np.sin(x).index == np.sin(x).index
    assert (x - y).index != (y - x).index


def test_a_number_is_not_the_step_of_that_index():
    tape = Tape()
    symbols = tape.inputs("q", 4)
    for index, number in ((3, 3.0), (2, 2.0)):
        by_step, by_number = symbols[0] + symbols[index], symbols[0] + number
        assert by_step.index != by_number.index
    assert run([symbols[0] + symbols[3], symbols[0] + 3.0], tape, q=(1.0, 5.0, 6.0, 7.0)) == [8.0, 4.0]


def test_steps_that_no_result_needs_are_not_written():
    tape = Tape()
    [x, y] = tape.inputs("q", 2)
    np.exp(y)
    lines = written(tape, [np.sin(x), 2.0], PYTHON)
    assert (lines.assignments, lines.results, lines.inputs) == ([], ["sin(q0)", "2.0"], [("q", 0)])


def test_an_unknown_function_is_refused():
    [x] = Tape().inputs("q", 1)
    with pytest.raises(TypeError):
        np.arccosh(x)
    with pytest.raises(TypeError):
        bool(x > 0.0)
