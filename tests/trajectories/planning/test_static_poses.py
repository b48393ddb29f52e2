from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.effects import CoulombFriction, CurrentOffset, Hysteresis, RigidBody
from exidyn.identification.model import Model
from exidyn.trajectories.clearances.clearance import random_positions
from exidyn.trajectories.clearances.collision import Collision
from exidyn.trajectories.clearances.region import Region, box
from exidyn.trajectories.errors import Infeasible, NothingToIdentify
from exidyn.trajectories.limits.check import check
from exidyn.trajectories.limits.leads import with_leads
from exidyn.trajectories.limits.usable_limits import usable
from exidyn.trajectories.planning.rests import Workspace
from exidyn.trajectories.planning.static_poses import APPROACH, DWELL, informative, static_poses

from ...parts.runs.robots import six_axis
from ...parts.small import small_arm, two_joints

pytestmark = pytest.mark.slow

LIMITS = two_joints.arm().limits
TICK = 0.004


@pytest.fixture(scope="module")
def run():
    return static_poses(Workspace(LIMITS, TICK), 8, two_joints.model())


def rests(trajectory):
    """Position, begin and end of each rest of a motion."""
    held = [part.duration >= DWELL and not np.any(part.jerk) for part in trajectory.parts]
    times = zip(trajectory.begins, trajectory.begins[1:], held, strict=False)
    return [(trajectory.at([begin]).position[0], begin, end) for begin, end, rests in times if rests]


def test_each_pose_is_held_twice_come_from_below_and_from_above(run):
    assert run.poses.shape == (8, 2)
    assert run.notes == ()
    held = rests(run.trajectory)
    assert len(held) == 16
    for place, (position, begin, end) in enumerate(held):
        pose, sign = run.poses[place // 2], (1.0, -1.0)[place % 2]
        assert end - begin == pytest.approx(DWELL)
        np.testing.assert_allclose(position, pose, atol=1e-6)
        before = run.trajectory.at(np.linspace(begin - 0.1, begin, 20))
        travel = sign * (pose - before.position)
        assert np.all(travel >= -1e-6)
        assert np.all(travel[0] > 0.1 * APPROACH)


def test_it_begins_and_ends_at_rest_at_one_pose_within_all_limits(run):
    ends = run.trajectory.at(np.array([0.0, run.trajectory.duration]))
    np.testing.assert_allclose(ends.position[0], ends.position[1], atol=1e-8)
    np.testing.assert_allclose([ends.velocity, ends.acceleration], 0.0, atol=1e-8)
    assert check(run.trajectory, LIMITS, TICK) == []
    assert check(with_leads(run.trajectory, LIMITS, TICK), LIMITS, TICK) == []


def test_a_given_start_is_kept_and_the_way_is_short():
    start = np.array([2.0, -2.0])
    found = static_poses(Workspace(LIMITS, TICK), 8, two_joints.model(), start=start)
    ends = found.trajectory.at(np.array([0.0, found.trajectory.duration]))
    np.testing.assert_allclose(ends.position, [start, start], atol=1e-8)

    def length(poses):
        return np.sum(np.max(np.abs(np.diff([start, *poses], axis=0)), axis=1))

    shuffled = [length(np.random.default_rng(k).permutation(found.poses)) for k in range(20)]
    assert length(found.poses) < np.mean(shuffled)


def six_bounded():
    """Six joints, of which each turns 2.5 rad both ways."""
    far = np.full(6, 2.5)
    return replace(six_axis(), limits=replace(six_axis().limits, position_lower=-far, position_upper=far))


def gravity_information(model, poses):
    """Log determinant by the known columns of gravity alone: what the first moments of the links do."""
    still = np.zeros_like(poses)
    columns = model.regressor(Motion.of(np.arange(len(poses)) * 1.0, poses, still, still))
    rows = columns.reshape(-1, columns.shape[2])
    everywhere = random_positions(model.robot, 300, seed=9)
    still = np.zeros_like(everywhere)
    wide = model.regressor(Motion.of(np.arange(300) * 1.0, everywhere, still, still)).reshape(900 * 2, -1)
    _, size, basis = np.linalg.svd(wide, full_matrices=False)
    seen = basis[size > 1e-6 * size[0]] / size[size > 1e-6 * size[0], None]
    return np.linalg.slogdet(seen @ rows.T @ rows @ seen.T)[1], len(seen)


def test_chosen_poses_are_more_informative_than_random_ones():
    robot = six_bounded()
    model = Model(robot, (RigidBody(), CurrentOffset()))
    candidates = random_positions(robot, 200, seed=1)
    best, count = gravity_information(model, candidates[informative(candidates, 6, robot.limits, model)])
    others = [gravity_information(model, random_positions(robot, 6, seed=seed))[0] for seed in range(2, 30)]
    assert best > max(others)
    assert best - np.median(others) > 0.25 * count  # each unknown's deviation an eighth smaller


def test_what_the_way_decides_at_rest_does_not_choose_poses():
    """Hysteresis keeps a torque at rest; between unrelated poses it would be noise."""
    robot = six_bounded()
    candidates = random_positions(robot, 100, seed=1)
    plain = Model(robot, (RigidBody(), CurrentOffset()))
    with_friction = plain + CoulombFriction() + Hysteresis()
    np.testing.assert_array_equal(
        informative(candidates, 6, robot.limits, plain),
        informative(candidates, 6, robot.limits, with_friction),
    )


def test_an_arm_that_could_collide_with_itself_never_does(tmp_path):
    robot, geometry = small_arm.small_arm(tmp_path)
    collision, limits = Collision.of(robot, geometry), usable(robot).limits
    model, notes = Model(robot, (RigidBody(), CurrentOffset())), []
    assert not collision.worst(static_poses(Workspace(limits, TICK), 8, model).trajectory).allowed
    for seed in range(4):
        kept = static_poses(Workspace(limits, TICK, [collision]), 8, model, seed=seed)
        assert collision.worst(kept.trajectory).allowed
        assert check(kept.trajectory, limits, TICK) == []
        assert len(kept.poses) + sum("left out" in note for note in kept.notes) == 8
        assert len(kept.poses) >= 4
        assert len(rests(kept.trajectory)) == 2 * len(kept.poses)
        notes += kept.notes
    assert any("left out: the move between two poses: " in note and " m after " in note for note in notes)
    assert any(note.endswith("takes a detour") for note in notes)


def test_an_arm_that_shows_nothing_or_has_no_room_is_refused():
    robot = two_joints.arm()
    robot.kinematics.gravity.linear = np.zeros(3)
    with pytest.raises(NothingToIdentify, match="two joints: at rest, no parameter"):
        static_poses(Workspace(LIMITS, TICK), 4, Model(robot, (RigidBody(), CoulombFriction())))
    narrow = replace(LIMITS, position_lower=np.array([-0.04, -2.5]), position_upper=np.array([0.04, 2.5]))
    with pytest.raises(Infeasible, match="joint 1: .* -0.04 to 0.04 rad, .* 0.05"):
        static_poses(Workspace(narrow, TICK), 4, two_joints.model())
    far = Region.of(two_joints.arm(), "flange", box([0.8, -9.0, -9.0], [9.0, 9.0, 9.0]))
    with pytest.raises(Infeasible, match=r"0 of 4000 .* 3 are needed.* has a margin of -0.\d+ m \(flange"):
        static_poses(Workspace(LIMITS, TICK, [far]), 3, two_joints.model())
