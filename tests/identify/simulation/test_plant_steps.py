"""The inner loop of the plant: by hand what LAPACK does, and compiled what Python does."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import EFFECTS
from exidyn.identification.errors import RobotError
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.plant import DriveControl, Plant, Transmission, drives, steps

from ...parts.runs.robots import random_motion, six_axis
from ..effects.test_effects import default


def positive(size, seed=0):
    half = np.random.default_rng(seed).normal(size=(size, size))
    return half @ half.T + np.eye(size)


def test_equations_are_solved_by_hand_as_by_lapack():
    matrix, right = positive(7), np.arange(7.0)
    expected = np.linalg.solve(matrix, right)
    for solve in (steps.solve, steps.solve_by_hand):
        np.testing.assert_allclose(solve(matrix, right), expected, rtol=1e-11)
        with pytest.raises(RobotError, match="its inertia is not positive definite"):
            solve(matrix - 2.0 * np.trace(matrix) * np.eye(7), right)
        with pytest.raises(RobotError, match="its inertia is not positive definite"):
            solve(np.diag([1.0, 0.0]), np.ones(2))


@pytest.mark.parametrize("elastic", [False, True])
@pytest.mark.parametrize("limit", [5.0, np.inf])
def test_compiled_steps_are_the_same(monkeypatch, elastic, limit):
    numba = pytest.importorskip("numba")
    if numba.config.DISABLE_JIT:
        pytest.skip("another test has switched compilation off in this process")
    assert steps.compiled(steps.through) is not steps.through
    fast = swung(elastic, limit)
    monkeypatch.setattr(drives, "compiled", lambda function: function)
    np.testing.assert_allclose(fast, swung(elastic, limit), rtol=1e-9, atol=1e-12)


def swung(elastic, limit):
    """Where an arm comes to that is commanded a jump, at whose end amplifiers are at their limit."""
    model = read_model("cobot")
    gears = Transmission(
        np.where(np.arange(6) < 2, 2e4, np.inf), np.full(6, 5.0), np.where(np.arange(6) < 1, 1e-3, 0.0)
    )
    control = DriveControl.tuned(np.full(6, 2.0), 15.0, np.full(6, limit))
    start, gain = np.zeros(6), model.robot.drive_gain
    plant = Plant(model, model.nominal_values, gain, start, control, transmission=gears if elastic else None)
    for _ in range(40):
        plant.step(start + 0.05, None, 0.004)
    return np.concatenate([plant.measure().position, plant.measure().current])


@pytest.mark.parametrize("key", [key for key, effect in EFFECTS.items() if effect.linear])
def test_what_is_declared_linear_is_so_in_velocity_and_acceleration_alone(key):
    robot, effect = six_axis(), default(key)
    one, other = random_motion(robot), random_motion(robot, seed=1, payload="L")
    same = replace(other, velocity=one.velocity, acceleration=one.acceleration)
    np.testing.assert_array_equal(effect.regressor(robot, one), effect.regressor(robot, same))
    still, twice = (
        replace(one, velocity=k * one.velocity, acceleration=k * one.acceleration) for k in (0.0, 2.0)
    )
    rest, once, double = (effect.regressor(robot, motion) for motion in (still, one, twice))
    np.testing.assert_allclose(double - rest, 2.0 * (once - rest))
