"""Motions for a payload keep to the limits with any payload that they must allow."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.rigid_regressor import body_regressor
from exidyn.identification.effects import Payload
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.errors import BadLimits, Infeasible
from exidyn.trajectories.planning.payload_motion import AnyPayload, largest_need, payload_plan
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.random_motion import random_fourier

COBOT = read_model("cobot")
LARGEST = AnyPayload(4.0, 0.1)
QUICK = {"iterations": 1, "starts": 1}


def allowed_bodies(count: int) -> list[pin.Inertia]:
    """Random payloads within `LARGEST`, half of them the heaviest at the reach."""
    random, bodies = np.random.default_rng(0), []
    for number in range(count):
        direction = random.normal(size=3)
        share = (1.0, 1.0) if number % 2 else random.uniform(size=2)
        center = LARGEST.reach * share[1] * direction / np.linalg.norm(direction)
        mass = LARGEST.mass * share[0]
        inertia = mass * (0.5 * LARGEST.reach) ** 2 * np.diag(random.uniform(0.5, 1.0, 3))
        bodies.append(pin.Inertia(mass, center, inertia))
    return bodies


def test_no_allowed_payload_needs_more_torque_than_the_bound() -> None:
    robot = COBOT.robot
    motion = random_fourier(robot.limits, 8.0, seed=1).at(np.linspace(0.0, 8.0, 60))
    rigid = Model(robot, COBOT.effects[:1])
    empty = rigid.torque(motion, rigid.nominal_values)
    columns = body_regressor(robot.kinematics, motion, robot.flange)
    bound = LARGEST.largest_torque(empty, columns)
    largest = np.abs(empty)
    for body in allowed_bodies(40):
        kinematics = robot.kinematics.copy()
        kinematics.inertias[robot.dof] += robot.flange.act(body)
        data = kinematics.createData()
        states = zip(motion.position, motion.velocity, motion.acceleration, strict=True)
        torque = np.array([pin.rnea(kinematics, data, *state) for state in states])
        assert np.all(np.abs(torque) <= bound + 1e-9)
        largest = np.maximum(largest, np.abs(torque))
    assert np.median(bound / largest) < 1.3  # the bound is not far above what payloads need


def test_poses_keep_to_the_limits_and_show_mass_and_center() -> None:
    plan = payload_plan(COBOT, LARGEST, Wishes(), poses=True)
    assert largest_need(plan.trajectory, COBOT, LARGEST, Wishes()).share <= 1.0
    assert "any up to 4 kg, center within 0.1 m" in str(plan.details["payload"])
    motion = plan.trajectory.every(0.05).motion("L")
    still = motion.position * 0.0
    resting = type(motion).of(motion.time, motion.position, still, still, payload="L")
    gravity = Payload("L").regressor(COBOT.robot, resting)[:, :, 6:].reshape(-1, 4)
    singular = np.linalg.svd(gravity / np.linalg.norm(gravity, axis=0), compute_uv=False)
    assert singular[-1] > 0.1  # none of the four parameters of gravity hides behind the others


def test_the_searched_motion_is_short_and_within_limits() -> None:
    plan = payload_plan(COBOT, AnyPayload(1.0, 0.05), Wishes(seconds=16.0), **QUICK)
    assert plan.trajectory.duration <= 20.0
    assert plan.criterion == "focus on payload"
    assert largest_need(plan.trajectory, COBOT, AnyPayload(1.0, 0.05), Wishes()).share <= 1.0


def test_a_heavy_payload_gets_a_slower_motion() -> None:
    """At the usual speed it would need more than a torque limit, at rest it does not."""
    payloads, said = AnyPayload(8.0, 0.2), []
    plan = payload_plan(COBOT, payloads, Wishes(seconds=16.0), **QUICK, progress=said.append)
    assert any("planning a slower motion" in words for words in said)
    assert largest_need(plan.trajectory, COBOT, payloads, Wishes()).share <= 1.0


@pytest.mark.parametrize(("mass", "cure"), [(200.0, "Try a smaller"), (45.0, "Give a fit of the arm")])
def test_a_payload_that_is_too_heavy_is_refused_before_the_search(mass, cure) -> None:
    vague = replace(COBOT, robot=replace(COBOT.robot, inertial_tolerance=0.5))
    with pytest.raises(Infeasible, match=f"up to {mass:g} kg .* joint. could need .* limit. {cure}"):
        payload_plan(vague, AnyPayload(mass, 0.1), Wishes(), seconds=1e9)
    with pytest.raises(BadLimits, match="largest mass of the payload: 0 kg"):
        AnyPayload(0.0, 0.1)
