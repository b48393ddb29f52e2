"""Each effect of a single joint against its formula, written out a second time in plain Python."""

from dataclasses import replace
from math import cos, exp, pi, sin, sqrt, tanh

import numpy as np
import pytest

from exidyn.identification.effects import (
    CoulombFriction,
    CurrentOffset,
    FrictionAsymmetry,
    JointSpring,
    LoadDependentFriction,
    NonlinearViscousFriction,
    PositionDependentFriction,
    RotorInertia,
    StribeckFriction,
    TemperatureDependentFriction,
    TorqueRipple,
    ViscousFriction,
)
from exidyn.identification.errors import NotRecorded
from exidyn.identification.model import Model

from ...parts.runs.robots import random_motion, six_axis, sliding

FORMULAS = {
    "rotor": (RotorInertia(), lambda s: [s.a]),
    "viscous": (ViscousFriction(), lambda s: [s.v]),
    "coulomb": (CoulombFriction(reversal=0.01), lambda s: [tanh(s.v / 0.01)]),
    "offset": (CurrentOffset(), lambda s: [1.0]),
    "asymmetry": (FrictionAsymmetry(reversal=0.02), lambda s: [abs(tanh(s.v / 0.02))]),
    "stribeck": (
        StribeckFriction(fade=0.2, reversal=0.01),
        lambda s: [tanh(s.v / 0.01) * exp(-s.v * s.v / 0.04)],
    ),
    "tustin": (
        StribeckFriction(fade=0.2, reversal=0.01, exponent=1.0),
        lambda s: [tanh(s.v / 0.01) * exp(-abs(s.v) / 0.2)],
    ),
    "load": (LoadDependentFriction(reversal=0.01), lambda s: [tanh(s.v / 0.01) * abs(s.load)]),
    "preloaded": (
        LoadDependentFriction(reversal=0.01, preload=2.0),
        lambda s: [tanh(s.v / 0.01) * (sqrt(4.0 + s.load**2) - 2.0)],
    ),
    "drag": (NonlinearViscousFriction(), lambda s: [s.v * abs(s.v)]),
    "root": (NonlinearViscousFriction(exponent=0.5), lambda s: [s.v**0.5 if s.v > 0 else -((-s.v) ** 0.5)]),
    "warm": (
        TemperatureDependentFriction(reference=20.0, reversal=0.01),
        lambda s: [s.v * (s.temperature - 20.0), tanh(s.v / 0.01) * (s.temperature - 20.0)],
    ),
    "eccentric": (
        PositionDependentFriction(harmonic=3, reversal=0.01),
        lambda s: [tanh(s.v / 0.01) * cos(3 * s.q), tanh(s.v / 0.01) * sin(3 * s.q)],
    ),
    "spring": (JointSpring(), lambda s: [s.q, 1.0]),
}


class Sample:
    """One joint at one time."""

    def __init__(self, motion, row, joint):
        self.q, self.v = motion.position[row, joint], motion.velocity[row, joint]
        self.a, self.load = motion.acceleration[row, joint], motion.load[row, joint]
        self.temperature = motion.temperature[row, joint]


@pytest.mark.parametrize(("effect", "formula"), FORMULAS.values(), ids=FORMULAS.keys())
@pytest.mark.parametrize("robot", [six_axis(), sliding()], ids=["six axis", "sliding"])
def test_torque_is_the_formula_on_its_own_joint(effect, formula, robot):
    motion = random_motion(robot)
    count = len(formula(Sample(motion, 0, 0)))
    expected = np.zeros((*motion.position.shape, count * robot.dof))
    for row in range(len(motion)):
        for joint in range(robot.dof):
            columns = slice(count * joint, count * joint + count)
            expected[row, joint, columns] = formula(Sample(motion, row, joint))
    np.testing.assert_allclose(effect.regressor(robot, motion), expected, rtol=1e-12, atol=1e-14)


def test_asymmetric_friction_differs_between_directions():
    robot = six_axis()
    forward = random_motion(robot)
    forward = replace(forward, velocity=np.full_like(forward.velocity, 0.5))
    backward = replace(forward, velocity=-forward.velocity)
    model = Model(robot, (CoulombFriction(("joint2",)), FrictionAsymmetry(("joint2",))))
    np.testing.assert_allclose(model.torque(forward, np.array([10.0, 3.0]))[:, 1], 13.0)
    np.testing.assert_allclose(model.torque(backward, np.array([10.0, 3.0]))[:, 1], -7.0)


def test_ripple_repeats_with_every_turn_of_the_motor():
    robot = replace(six_axis(), coupling=np.eye(6))
    motion = random_motion(robot)
    ripple = TorqueRipple(("joint3",), harmonic=1)
    once = ripple.regressor(robot, motion)
    turned = replace(motion, position=motion.position + 2 * pi / robot.gear_ratio)
    np.testing.assert_allclose(ripple.regressor(robot, turned), once, atol=1e-10)
    half = replace(motion, position=motion.position + pi / robot.gear_ratio)
    np.testing.assert_allclose(ripple.regressor(robot, half), -once, atol=1e-10)
    np.testing.assert_allclose(once[:, 2, 0], np.cos(90.0 * motion.position[:, 2]), atol=1e-12)
    robot = six_axis()
    several = [
        effect(harmonic=k) for effect in (TorqueRipple, PositionDependentFriction) for k in (1, 2, 0.5)
    ]
    assert len(set(Model(robot, tuple(several)).names)) == 6 * 6 * 2


def test_ripple_of_a_coupled_motor_gives_the_joints_its_power():
    robot = six_axis()
    motion = random_motion(robot)
    values = np.random.default_rng(2).normal(size=12)
    torque = TorqueRipple(harmonic=2).regressor(robot, motion) @ values
    for row in range(len(motion)):
        power = 0.0
        for motor in range(6):
            turn = sum(robot.coupling[motor, j] * motion.position[row, j] for j in range(6))
            speed = sum(robot.coupling[motor, j] * motion.velocity[row, j] for j in range(6))
            angle = 2 * robot.gear_ratio[motor] * turn
            power += speed * (values[2 * motor] * cos(angle) + values[2 * motor + 1] * sin(angle))
        assert torque[row] @ motion.velocity[row] == pytest.approx(power, abs=1e-9)


def test_temperature_that_was_not_recorded_is_asked_for():
    robot = six_axis()
    motion = random_motion(robot)
    motion.temperature[3, 1] = motion.temperature[:, 4] = np.nan
    with pytest.raises(NotRecorded, match="temperatures were not recorded.* on joint2, joint5; record them"):
        TemperatureDependentFriction().regressor(robot, motion)
    measured = TemperatureDependentFriction(("joint1", "joint6")).regressor(robot, motion)
    assert np.isfinite(measured).all()
