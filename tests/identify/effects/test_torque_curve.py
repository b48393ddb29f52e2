"""A curve of torque: splines of scipy, written out another way, over each quantity."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from exidyn.identification.effects import TorqueCurve
from exidyn.identification.effects.torque_curve import ABSCISSAE, DENSE, SPLINES

from ...parts.runs.robots import random_motion, six_axis

pytestmark = pytest.mark.numerical

JOINT = "joint3"


def spline(coefficients, x, low, high):
    knots = np.concatenate([[low] * 3, np.linspace(low, high, SPLINES - 2), [high] * 3])
    return BSpline(knots, coefficients, 3)(np.clip(x, low, high))


@pytest.mark.parametrize("over", ABSCISSAE)
def test_a_curve_is_the_spline_of_its_coefficients(over):
    robot = six_axis()
    motion = random_motion(robot)
    joint, sizes = robot.index(JOINT), ("velocity", "direction", "load")
    low, high = (0.0, 0.7) if over in sizes else (-0.5, 0.7)
    coefficients = np.random.default_rng(0).normal(size=SPLINES)
    values = {"velocity": np.abs(motion.velocity), "direction": np.abs(motion.velocity)}
    values |= {"load": np.abs(motion.load)}
    x = values.get(over, motion.position)[:, joint]
    if over in sizes:
        expected = spline(coefficients, np.arcsinh(x / (DENSE * high)), 0.0, np.arcsinh(1.0 / DENSE))
    else:
        expected = spline(coefficients, x, low, high)
    if over in ("velocity", "load", "position and direction"):
        expected = expected * np.tanh(motion.velocity[:, joint] / 0.003)
    effect = TorqueCurve((JOINT,), over=over, low=low, high=high)
    torque = effect.regressor(robot, motion) @ coefficients
    np.testing.assert_allclose(torque[:, joint], expected, atol=1e-7)
    assert not np.any(np.delete(torque, joint, axis=1))


def test_equal_coefficients_are_dry_friction():
    robot = six_axis()
    motion = random_motion(robot)
    torque = TorqueCurve((JOINT,), over="velocity").regressor(robot, motion).sum(axis=2)
    joint = robot.index(JOINT)
    np.testing.assert_allclose(torque[:, joint], np.tanh(motion.velocity[:, joint] / 0.003), atol=1e-12)
    with pytest.raises(ValueError, match="over = 'speed': expected one of velocity, direction, load"):
        TorqueCurve(over="speed")
