"""Flange force: exact away from singular poses, finite near them, and a force alone for few joints."""

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Robot
from exidyn.identification.contact.wrench import damped_wrench, flange_jacobian, flange_wrenches
from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.robot_files.robot_file import read_model

from ...parts.runs.robots import six_axis
from ...parts.small import two_joints


def test_the_jacobian_is_that_of_the_flange():
    robot = six_axis()
    data, q = robot.kinematics.createData(), np.random.default_rng(0).normal(size=6)
    jacobian = flange_jacobian(robot, data, q)
    for joint in range(6):
        step = 1e-6 * np.eye(6)[joint]
        places = []
        for side in (step, -step):
            pin.forwardKinematics(robot.kinematics, data, q + side)
            places.append((data.oMi[6] * robot.flange).translation.copy())
        np.testing.assert_allclose(jacobian[:3, joint], (places[0] - places[1]) / 2e-6, atol=1e-8)


def test_a_wrench_is_recovered_whatever_the_scale():
    random, wrench = np.random.default_rng(1), np.array([10.0, -5.0, 3.0, 1.0, 0.5, -2.0])
    for _ in range(5):
        turn, _ = np.linalg.qr(random.normal(size=(6, 6)))
        jacobian = np.diag([1.0, 1.0, 1.0, 10.0, 10.0, 10.0]) @ turn @ np.diag(random.uniform(0.5, 1.5, 6))
        scale = np.exp(0.2 * random.normal(size=6))
        np.testing.assert_allclose(
            damped_wrench(jacobian, jacobian.T @ wrench, scale, 0.1), wrench, rtol=1e-9
        )


def test_wrenches_of_an_arm_explain_its_torques():
    robot, random = six_axis(), np.random.default_rng(1)
    q, torque = random.normal(size=(2, 5, 6))
    wrenches = flange_wrenches(robot, q, torque, np.ones((5, 6)))
    data = robot.kinematics.createData()
    left = [
        t - flange_jacobian(robot, data, row).T @ w for t, row, w in zip(torque, q, wrenches, strict=True)
    ]
    assert np.linalg.norm(left) < np.linalg.norm(torque)


def test_near_a_singular_pose_the_force_stays_small_and_other_directions_keep_theirs():
    jacobian = np.diag([1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    jacobian[3:] *= 10.0  # the lever of moments
    for weak in (1e-3, 1e-6, 0.0):
        jacobian[2, 2] = weak
        wrench = damped_wrench(jacobian, np.array([2.0, 3.0, 0.01, 0.0, 0.0, 0.0]), np.ones(6), 0.1)
        np.testing.assert_allclose(wrench[:2], [2.0, 3.0], rtol=1e-9)
        assert abs(wrench[2]) <= 0.01 / 0.05


def test_a_large_arm_shows_the_weight_of_a_heavy_tool():
    model = read_model("kr270")
    tool = model + Payload("L", known_parameters(175.0, (0.05, 0.03, -0.22)))
    random, robot = np.random.default_rng(2), model.robot
    q = random.uniform(robot.limits.position_lower, robot.limits.position_upper, (200, 6))
    still = Motion.of(np.zeros(200), q, np.zeros_like(q), np.zeros_like(q), payload="L")
    torque = -tool.effects[-1].known_torque(robot, still)
    wrenches = flange_wrenches(
        robot, q, torque, np.array([9.0, 13.0, 9.0, 3.5, 3.2, 3.3]) * np.ones((200, 1))
    )
    assert np.median(wrenches[:, 2]) == pytest.approx(-175.0 * 9.81, rel=0.02)
    assert np.mean(wrenches[:, 2]) == pytest.approx(-175.0 * 9.81, rel=0.1)


def test_few_joints_give_as_much_of_a_force_as_they_see():
    robot = two_joints.arm()
    q, force = np.array([[0.3, 0.9]]), np.array([5.0, 0.0, -8.0])
    jacobian = flange_jacobian(robot, robot.kinematics.createData(), q[0])
    wrench = flange_wrenches(robot, q, (jacobian[:3].T @ force)[None], np.ones((1, 2)))
    np.testing.assert_allclose(wrench[0], [*force, 0.0, 0.0, 0.0], atol=1e-9)
    kinematics = pin.Model()
    kinematics.addJoint(0, pin.JointModelRY(), pin.SE3.Identity(), "pivot")
    robot = Robot("one", kinematics, flange=pin.SE3(np.eye(3), np.array([0.5, 0.0, 0.0])))
    wrench = flange_wrenches(robot, np.zeros((1, 1)), np.array([[3.0]]), np.ones((1, 1)))
    np.testing.assert_allclose(wrench[0], [0.0, 0.0, -6.0, 0.0, 0.0, 0.0], atol=1e-12)


def test_unknown_torques_give_unknown_forces():
    robot = two_joints.arm()
    torque = np.array([[1.0, np.nan], [1.0, 1.0]])
    wrench = flange_wrenches(robot, np.zeros((2, 2)), torque, np.ones((2, 2)))
    assert np.isnan(wrench[0]).all()
    assert np.isfinite(wrench[1]).all()
    assert pytest.approx(0.0) == wrench[1, 1]
