"""The gradient by the motion must be right for every effect, so that excitation may use any."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import LoadDependentFriction, Payload, RigidBody, ViscousFriction
from exidyn.identification.effects import known_parameters as known
from exidyn.identification.model import Model

from ...parts.runs.robots import random_motion
from .test_effects import POINTWISE, ROBOTS, default

pytestmark = pytest.mark.numerical

STEP = 2e-6


@pytest.fixture(params=ROBOTS.values(), ids=ROBOTS.keys())
def robot(request):
    return request.param()


def moved(motion, direction, step):
    shifted = {name: getattr(motion, name) + step * shift for name, shift in direction.items()}
    return replace(motion, **shifted)


def directional(function, motion, direction):
    """Derivative of a number along a direction of the motion."""
    return (function(moved(motion, direction, STEP)) - function(moved(motion, direction, -STEP))) / (2 * STEP)


def directions(motion, seed, names=("position", "velocity", "acceleration", "load")):
    random = np.random.default_rng(seed)
    return {name: random.normal(size=motion.position.shape) for name in names}


def along(gradient, direction):
    return sum(np.sum(getattr(gradient, name) * shift) for name, shift in direction.items())


@pytest.mark.parametrize("key", POINTWISE)
def test_gradient_of_every_effect(key, robot):
    effect, motion = default(key), random_motion(robot, payload="L")
    weights = np.random.default_rng(1).normal(size=effect.regressor(robot, motion).shape)
    direction = directions(motion, 2)
    expected = directional(lambda m: np.sum(weights * effect.regressor(robot, m)), motion, direction)
    found = along(effect.motion_gradient(robot, motion, weights, np.zeros_like(motion.position)), direction)
    assert found == pytest.approx(expected, rel=1e-5, abs=1e-4)


@pytest.mark.parametrize("which", ["whole", "one joint"])
def test_gradient_of_a_model_passes_through_the_load(robot, which):
    joints = None if which == "whole" else (robot.joints[2],)
    body = Payload("L", known(3.0, (0.1, 0.0, 0.2)))
    model = Model(robot, (RigidBody(), ViscousFriction(), LoadDependentFriction(joints=joints), body))
    motion = random_motion(robot, payload="L")
    random = np.random.default_rng(3)
    weights = random.normal(size=(*motion.position.shape, len(model.names)))
    pull = random.normal(size=motion.position.shape)

    def total(m):
        m = model.loaded(m)
        return np.sum(weights * model.regressor(m)) + np.sum(pull * model.known_torque(m))

    direction = directions(motion, 4, ("position", "velocity", "acceleration"))
    expected = directional(total, motion, direction)
    found = along(model.motion_gradient(model.loaded(motion), weights, pull), direction)
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-4)
