import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.rigid_regressor import (
    body_gradient,
    body_regressor,
    rigid_gradient,
    rigid_regressor,
)
from exidyn.identification.arm.robot import Robot
from exidyn.identification.effects.rigid_body import inertial_parameters

from ...parts.runs.robots import kinematics, placement, random_motion
from .test_rigid_regressor import TREES

pytestmark = pytest.mark.numerical

STEP = 1e-5
FLANGE = placement(np.random.default_rng(11))


@pytest.fixture(params=TREES.values(), ids=TREES.keys())
def tree(request):
    return kinematics(**request.param, seed=5)


@pytest.fixture
def state(tree):
    motion = random_motion(Robot("tree", tree), samples=7)
    return [motion.position, motion.velocity, motion.acceleration]


def at(state):
    return Motion.of(np.arange(len(state[0])), *state)


def central_difference(function, state, which):
    """Derivative of each sample's value by each joint's quantity, shape (t, n)."""
    out = np.zeros_like(state[which])
    for joint in range(out.shape[1]):
        sides = []
        for sign in (1, -1):
            moved = [value.copy() for value in state]
            moved[which][:, joint] += sign * STEP
            sides.append(function(moved))
        out[:, joint] = (sides[0] - sides[1]) / (2 * STEP)
    return out


@pytest.mark.parametrize("which", [0, 1, 2], ids=["position", "velocity", "acceleration"])
def test_gradient_is_that_of_differences(tree, state, which):
    weights = np.random.default_rng(1).normal(size=(len(state[0]), tree.nv, 10 * tree.nv))

    def total(moved):
        return np.sum(weights * rigid_regressor(tree, at(moved)), axis=(1, 2))

    expected = central_difference(total, state, which)
    found = rigid_gradient(tree, at(state), weights)[which]
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-7 * np.abs(expected).max() + 1e-8)


@pytest.mark.parametrize("which", [0, 1, 2], ids=["position", "velocity", "acceleration"])
def test_gradient_of_a_body_on_the_flange_is_that_of_differences(tree, state, which):
    weights = np.random.default_rng(2).normal(size=(len(state[0]), tree.nv, 10))

    def total(moved):
        return np.sum(weights * body_regressor(tree, at(moved), FLANGE), axis=(1, 2))

    expected = central_difference(total, state, which)
    found = body_gradient(tree, at(state), FLANGE, weights)[which]
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-7 * np.abs(expected).max() + 1e-8)


def test_gradient_of_torque_is_that_of_pinocchio(tree, state):
    """Weights u times the inertial values give u' times the derivatives of inverse dynamics."""
    values = np.concatenate([inertial_parameters(inertia) for inertia in list(tree.inertias)[1:]])
    pick = np.random.default_rng(3).normal(size=state[0].shape)
    found = rigid_gradient(tree, at(state), pick[:, :, None] * values)
    data = tree.createData()
    expected = np.zeros_like(found)
    for row, one in enumerate(zip(*state, strict=True)):
        derivatives = pin.computeRNEADerivatives(tree, data, *one)
        full = [derivatives[0], derivatives[1], _symmetric(derivatives[2])]
        expected[:, row] = [pick[row] @ by for by in full]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-8)


def _symmetric(upper):
    return np.triu(upper) + np.triu(upper, 1).T
