import numpy as np
import pytest

from exidyn.identification.effects import CoulombFriction, KinematicCoupling, RotorInertia, ViscousFriction
from exidyn.identification.errors import RobotError, UnknownJoint
from exidyn.identification.model import Model

from ...parts.runs.robots import random_motion, six_axis

JOINT, OTHER, RATIO, REVERSAL = 4, 3, -0.7, 0.05
COUPLING = KinematicCoupling("joint5", "joint4", ratio=RATIO, reversal=REVERSAL)


def dry(velocity):
    return np.tanh(velocity / REVERSAL)


def test_coupled_motors_are_their_own_friction_carried_to_the_joints():
    """Model with coupling = C^T f(C dq), where `other` keeps what it feels when it moves alone."""
    robot = six_axis()
    motion = random_motion(robot, samples=200)
    inertia, viscous, coulomb = np.random.default_rng(4).uniform(1, 9, (3, 6))
    turn = np.eye(6)
    turn[JOINT, OTHER] = RATIO
    motor_velocity, motor_acceleration = motion.velocity @ turn.T, motion.acceleration @ turn.T
    on_motors = inertia * motor_acceleration + viscous * motor_velocity + coulomb * dry(motor_velocity)
    expected = on_motors @ turn

    alone_inertia, alone_viscous = inertia.copy(), viscous.copy()
    alone_inertia[OTHER] += RATIO**2 * inertia[JOINT]
    alone_viscous[OTHER] += RATIO**2 * viscous[JOINT]
    expected[:, OTHER] -= RATIO * coulomb[JOINT] * dry(RATIO * motion.velocity[:, OTHER])

    model = Model(robot, (RotorInertia(), ViscousFriction(), CoulombFriction(reversal=REVERSAL), COUPLING))
    assert model.names[-3:] == ["Ia5_4", "Fv5_4", "Fc5_4"]
    coupled = [RATIO * inertia[JOINT], RATIO * viscous[JOINT], coulomb[JOINT]]
    values = np.concatenate([alone_inertia, alone_viscous, coulomb, coupled])
    np.testing.assert_allclose(model.torque(motion, values), expected, rtol=1e-12, atol=1e-10)


def test_a_joint_is_coupled_to_another_that_is_there():
    with pytest.raises(RobotError, match="'joint5' cannot be coupled to itself"):
        KinematicCoupling("joint5", "joint5").parameters(six_axis())
    with pytest.raises(UnknownJoint, match="joint7"):
        KinematicCoupling("joint5", "joint7").parameters(six_axis())
