from dataclasses import replace

import numpy as np
import pytest

from exidyn.trajectories.clearances.collision import Collision
from exidyn.trajectories.errors import Infeasible
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.kinds.rests import Workspace
from exidyn.trajectories.kinds.single_joint import single_joint_runs
from exidyn.trajectories.limits.check import check
from exidyn.trajectories.limits.leads import with_leads
from exidyn.trajectories.limits.usable_limits import usable

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


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("tick", [0.002, 0.012])
def test_all_limits_are_kept_with_leads_and_on_ticks(seed, tick):
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


def test_a_joint_swings_only_as_far_as_the_arm_is_clear(tmp_path):
    robot, geometry = small_arm.small_arm(tmp_path)
    collision, limits = Collision.of(robot, geometry), usable(robot).limits
    pose = np.array([0.0, 0.6, 1.3, 0.1, 0.0])
    assert not collision.worst(single_joint_runs(Workspace(limits, TICK), range(5), pose)).allowed
    run = single_joint_runs(Workspace(limits, TICK, [collision]), range(5), pose)
    assert collision.worst(run).allowed
    assert check(run, limits, TICK) == []


def test_a_pose_at_a_limit_leaves_no_room():
    with pytest.raises(Infeasible, match="joint 2: at 2.49 rad its excursion is at most 0.008 rad"):
        single_joint_runs(Workspace(LIMITS, TICK), [0, 1], np.array([0.0, 2.49]))


def test_a_pose_that_collides_reports_what(tmp_path):
    robot, geometry = small_arm.small_arm(tmp_path)
    collision, limits = Collision.of(robot, geometry), usable(robot).limits
    folded = np.array([0.0, 0.0, 2.8, 0.0, 0.0])
    with pytest.raises(Infeasible, match="the pose: .* to .* misses its safety margin by"):
        single_joint_runs(Workspace(limits, TICK, [collision]), [0], folded)
