import numpy as np
import pytest

from exidyn.identification.effects import SpringBalancer

from ...parts.runs.robots import random_motion, six_axis

pytestmark = pytest.mark.numerical

D21, D22, PHI = 0.6964, 0.1847, -1.6148  # the paper's table II and (26)
KR, K0 = 5.04e4, -7.85e4  # the paper's table III
BALANCER = SpringBalancer("joint2", d21=0.6964, d22=0.1847, phi=-1.6148)


def paper(position, arctangent):
    """Torque on the joint per unit of Kr and K0, (26) to (35) as printed."""
    q21 = PHI + position
    rl24 = np.sqrt(D21**2 + D22**2 + 2 * D21 * D22 * np.cos(q21))
    q23 = arctangent(D21 + D22 * np.cos(q21), -D22 * np.sin(q21))
    psi = q23 - q21 - np.pi / 2
    return np.stack([rl24 * np.sin(psi) * D22, np.sin(psi) * D22], axis=-1)


def columns(position, balancer=BALANCER):
    robot = six_axis()
    motion = random_motion(robot, samples=len(position))
    motion.position[:, 1] = position
    regressor = balancer.regressor(robot, motion)
    assert not np.any(regressor[:, [0, 2, 3, 4, 5]])
    return regressor[:, 1]


def test_table_iii_gives_what_holds_the_arm_up():
    position = np.linspace(-np.pi, np.pi, 401)
    np.testing.assert_allclose(columns(position), -paper(position, np.arctan2), atol=1e-14)
    forward = np.array([0.0])
    gravity = -3.44e2 * 9.81  # MX2R, with x2 forward and z2 such that the arm falls toward positive q2
    motor = columns(forward) @ np.array([KR, K0])
    assert motor[0] == pytest.approx(7.68e3, rel=1e-3)
    assert np.sign(motor[0]) == -np.sign(gravity)


def test_arctangent_and_force_are_those_of_the_geometry():
    theta = np.concatenate([np.linspace(-3.1, -0.05, 50), np.linspace(0.05, 3.1, 50)])
    printed = paper(theta - PHI, lambda y, x: np.arctan(y / x))
    sides = np.sign(theta)[:, None]
    np.testing.assert_allclose(columns(theta - PHI), sides * printed, atol=1e-14)
    position, step = np.linspace(-3.0, 3.0, 50), 1e-6
    stretch = (BALANCER.length(position + step) - BALANCER.length(position - step)) / (2 * step)
    np.testing.assert_allclose(columns(position)[:, 1], -stretch, atol=1e-9)
    np.testing.assert_allclose(columns(position)[:, 0], -stretch * BALANCER.length(position), atol=1e-9)


def test_upright_arm_and_folded_spring_are_finite():
    upright = np.array([-PHI, np.pi - PHI, -np.pi - PHI])
    np.testing.assert_allclose(columns(upright), 0.0, atol=1e-15)
    folded = SpringBalancer("joint2", d21=0.5, d22=0.5, phi=np.pi)
    robot = six_axis()
    motion = random_motion(robot)
    motion.position[:, 1] = 0.0
    assert np.isfinite(folded.regressor(robot, motion)).all()
    assert all(np.isfinite(d).all() for d in folded.shape_derivatives(robot, motion).values())
