"""Arms that stand on a wall or hang from a ceiling, of which the description is upright."""

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion, differentiate
from exidyn.identification.arm.rigid_regressor import rigid_regressor
from exidyn.identification.effects.rigid_body import inertial_parameters
from exidyn.identification.plausible.change import with_gravity
from exidyn.identification.plausible.proposal import propose
from exidyn.identification.plausible.proposal_text import proposal_text, robot_toml
from exidyn.identification.plausible.proposed_units import GRAVITY
from exidyn.identification.robot_files.robot_file import read_model

from ...parts.runs.logs import columns, short_log

LOG = short_log()
ROBOT = LOG.model.robot
WALL = (0.8, 0.0, -0.6)


def torque_under(direction):
    """Of the bodies and some friction, shape (t, n) [N m]."""
    velocity, acceleration = differentiate(LOG.position, 100.0)
    motion = Motion.of(LOG.time, LOG.position, velocity, acceleration)
    bodies = list(ROBOT.kinematics.inertias)[1:]
    values = np.concatenate([inertial_parameters(body) for body in bodies])
    torque = (
        rigid_regressor(with_gravity(LOG.model, 9.81 * np.array(direction)).robot.kinematics, motion) @ values
    )
    friction = np.array([12.0, 12.0, 8.0, 3.0]) * np.tanh(velocity / 0.02)
    noise = np.random.default_rng(4).normal(size=torque.shape)
    return torque + friction + 0.02 * torque.std(axis=0) * noise


def proposed(effort, name="tau{k}"):
    named = {"t": LOG.time, **columns("q{k}", LOG.position), **columns(name, effort)}
    return propose(list(named), np.column_stack(list(named.values())), LOG.model)


def asked(found):
    return [guess.what for guess in found.guesses]


def test_an_arm_on_a_wall_keeps_its_order_of_joints_and_its_unit_of_torque(tmp_path):
    found = proposed(torque_under(WALL))
    assert found.columns["position"] == tuple(f"q{k}" for k in range(1, ROBOT.dof + 1))
    assert "torque" in found.columns
    assert np.linalg.norm(found.gravity) == pytest.approx(9.81)
    assert np.array(found.gravity) @ WALL / 9.81 > np.cos(np.radians(5))
    assert GRAVITY in proposal_text(found)
    (tmp_path / "arm.toml").write_text(robot_toml(found, LOG.model, "", "log.csv"))
    field = read_model(tmp_path / "arm.toml").robot.gravity
    assert field / 9.81 == pytest.approx(WALL, abs=0.09)


def test_an_arm_that_hangs_from_a_ceiling_is_known_by_friction():
    found = proposed(torque_under((0.0, 0.0, 1.0)) / ROBOT.drive_gain, "i{k}")
    assert found.gravity == pytest.approx((0.0, 0.0, 9.81), abs=1e-6)
    assert all(gain.positive > 0.5 for gain in found.gains)


@pytest.mark.parametrize("lean", [0.0, 0.05])
def test_nothing_is_said_of_an_arm_that_stands_about_as_described(lean):
    found = proposed(torque_under((np.sin(lean), 0.0, -np.cos(lean))))
    assert GRAVITY not in asked(found)
    assert found.gravity == ()
