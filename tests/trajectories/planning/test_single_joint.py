"""Motions of one joint at a time: sweeps at constant velocity, and a fast and a slow swing."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.trajectories.clearances.collision import Collision
from exidyn.trajectories.errors import Infeasible
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.limits.check import check
from exidyn.trajectories.limits.leads import with_leads
from exidyn.trajectories.limits.usable_limits import usable
from exidyn.trajectories.planning.rests import Workspace
from exidyn.trajectories.planning.single_joint import constant_velocity_sweeps, single_joint_runs

from ...parts.small import small_arm
from ...parts.small.two_joints import arm

pytestmark = pytest.mark.slow

LIMITS = arm().limits
TICK = 0.004
POSE = np.array([0.1, -0.3])


def test_joints_move_one_at_a_time_in_the_order_given():
    run = single_joint_runs(Workspace(LIMITS, TICK), [1, 0], POSE)
    moves = np.abs(run.every(TICK).velocity) > 1e-9
    assert not np.any(np.all(moves, axis=1))
    assert np.flatnonzero(moves[:, 1])[-1] < np.flatnonzero(moves[:, 0])[0]
    states = run.every(TICK)
    for row in (0, -1):
        np.testing.assert_allclose(states.position[row], POSE, atol=1e-9)


def test_the_fast_part_uses_a_limit_and_the_slow_a_quarter_of_the_speed():
    run = single_joint_runs(Workspace(LIMITS, TICK), [0], POSE)
    fast, slow = [part for part in run.parts if isinstance(part, Fourier)]
    reached = fast.extremes()
    use = [
        reached.velocity.upper[0] / 3.0,
        reached.acceleration.upper[0] / 12.0,
        reached.jerk.upper[0] / 200.0,
    ]
    assert max(use) == pytest.approx(0.9, rel=0.01)
    assert slow.extremes().velocity.upper[0] == pytest.approx(reached.velocity.upper[0] / 4, rel=0.01)
    assert slow.extremes().position.upper[0] == pytest.approx(reached.position.upper[0])
    assert reached.position.upper[0] - POSE[0] == pytest.approx(1.0)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("tick", [0.002, 0.012])
def test_swings_keep_all_limits_with_leads_and_on_ticks(seed, tick):
    random = np.random.default_rng(seed)
    lower, upper = -random.uniform(0.3, 2.0, 2), random.uniform(0.3, 2.0, 2)
    limits = replace(
        LIMITS,
        position_lower=lower,
        position_upper=upper,
        velocity=random.uniform(0.5, 4.0, 2),
        velocity_lower=-random.uniform(0.5, 4.0, 2),
        acceleration=random.uniform(1.0, 20.0, 2),
        acceleration_lower=-random.uniform(1.0, 20.0, 2),
        jerk=random.uniform(10.0, 1000.0, 2),
    )
    run = single_joint_runs(Workspace(limits, tick), [0, 1], random.uniform(0.8 * lower, 0.8 * upper))
    assert check(run, limits, tick) == []
    assert check(with_leads(run, limits, tick), limits, tick) == []


@pytest.mark.parametrize("tick", [0.004, 0.012])
def test_sweeps_keep_all_limits_with_leads_and_on_ticks(tick):
    one_way = replace(
        LIMITS, velocity_lower=np.array([-1.0, -2.0]), acceleration_lower=np.array([-5.0, -20.0])
    )
    sweeps = constant_velocity_sweeps(Workspace(one_way, tick), [0, 1], POSE)
    assert check(sweeps, one_way, tick) == []
    assert check(with_leads(sweeps, one_way, tick), one_way, tick) == []
    for part in sweeps.parts:
        assert part.duration / tick == pytest.approx(round(part.duration / tick), abs=1e-6)
    np.testing.assert_allclose(sweeps.at([sweeps.duration]).position[0], POSE, atol=1e-8)


@pytest.fixture
def cell(tmp_path):
    """Limits of an arm, and its distances to itself."""
    robot, geometry = small_arm.small_arm(tmp_path)
    return usable(robot).limits, Collision.of(robot, geometry)


@pytest.mark.parametrize(
    ("plan", "joints", "elbow"),
    [(single_joint_runs, range(5), 1.3), (constant_velocity_sweeps, range(3), 0.8)],
)
def test_a_joint_moves_only_as_far_as_the_arm_is_clear(cell, plan, joints, elbow):
    (limits, collision), pose = cell, np.array([0.0, 0.6, elbow, 0.1, 0.0])
    assert not collision.worst(plan(Workspace(limits, TICK), joints, pose)).allowed
    run = plan(Workspace(limits, TICK, [collision]), joints, pose)
    assert collision.worst(run).allowed
    assert check(run, limits, TICK) == []


def test_the_clear_range_ends_near_where_something_is_in_contact(cell):
    (limits, collision), pose = cell, np.array([0.0, 0.6, 0.8, 0.1, 0.0])
    bounds = Workspace(limits, TICK, [collision]).clear_range(pose, 1)
    positions = np.tile(pose, (2001, 1))
    positions[:, 1] = np.linspace(*bounds, 2001)
    assert np.min(collision.margins(positions)) >= 0.0
    wide = (limits.position_lower[1], limits.position_upper[1])
    narrowed = [bound for bound, widest in zip(bounds, wide, strict=True) if abs(bound - widest) > 1e-9]
    assert narrowed
    for bound in narrowed:
        outside = pose.copy()
        outside[1] = bound + 0.06 * np.sign(bound - pose[1])
        assert np.min(collision.margins(outside[None])) < 0.0


def test_a_joint_without_room_is_refused(cell):
    with pytest.raises(Infeasible, match="joint 2: at 2.49 rad its excursion is at most 0.008 rad"):
        single_joint_runs(Workspace(LIMITS, TICK), [0, 1], np.array([0.0, 2.49]))
    narrow = replace(LIMITS, position_lower=np.array([-2.5, 0.5]), position_upper=np.array([2.5, 0.51]))
    with pytest.raises(Infeasible, match="joint 2: from 0.5 to 0.51 rad there is no room to cruise"):
        constant_velocity_sweeps(Workspace(narrow, TICK), [1], np.array([0.1, 0.505]))
    (limits, collision), folded = cell, np.array([0.0, 0.0, 2.8, 0.0, 0.0])
    with pytest.raises(Infeasible, match="the pose: .* to .* misses its safety margin by"):
        single_joint_runs(Workspace(limits, TICK, [collision]), [0], folded)


def cruises(sweeps, joint):
    """Velocity, duration, spread of velocity and positions of each cruise of a joint, sampled on ticks."""
    states = sweeps.every(TICK)
    steady = (np.abs(states.acceleration[:, joint]) < 1e-9) & (np.abs(states.velocity[:, joint]) > 1e-6)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], steady, [False]]).astype(int)))
    return [
        (
            states.velocity[start, joint],
            (end - start) * TICK,
            np.ptp(states.velocity[start:end, joint]),
            states.position[start:end, joint],
        )
        for start, end in zip(edges[::2], edges[1::2], strict=True)
    ]


@pytest.mark.parametrize("joint", [0, 1])
def test_every_velocity_is_cruised_at_exactly_both_ways(joint):
    """From a hundredth to six tenths of the velocity limit of 3 rad/s."""
    sweeps = constant_velocity_sweeps(Workspace(LIMITS, TICK), [joint], POSE)
    for velocity in np.geomspace(0.03, 1.8, 6):
        forth, back = (
            next(cruise for cruise in cruises(sweeps, joint) if cruise[0] == pytest.approx(wanted, rel=1e-9))
            for wanted in (velocity, -velocity)
        )
        for _, duration, spread, _ in (forth, back):
            assert spread < 1e-12
            assert max(1.0, min(10.0, 4.0 / velocity) - 0.5) <= duration <= 10.0 + TICK
        assert np.ptp(forth[3]) == pytest.approx(np.ptp(back[3]), abs=1e-9)
        assert forth[3][0] == pytest.approx(back[3][-1], abs=2 * velocity * TICK)
    states, other = sweeps.every(TICK), 1 - joint
    np.testing.assert_array_equal(states.position[:, other], POSE[other])
    for row in (0, -1):
        np.testing.assert_allclose(states.position[row], POSE, atol=1e-8)
        np.testing.assert_allclose([states.velocity[row], states.acceleration[row]], 0.0, atol=1e-8)


def test_a_narrow_range_makes_the_fastest_of_its_speeds_slower():
    narrow = replace(LIMITS, position_lower=np.array([-0.4, -2.5]), position_upper=np.array([0.4, 2.5]))
    sweeps = constant_velocity_sweeps(Workspace(narrow, TICK), [0], POSE)
    lasting = [abs(velocity) for velocity, duration, *_ in cruises(sweeps, 0) if duration >= 0.99]
    assert len(lasting) >= 12
    assert 0.5 < max(lasting) < 0.8
    reached = sweeps.extremes().position
    assert -0.4 - 1e-9 <= reached.lower[0] <= reached.upper[0] <= 0.4 + 1e-9
