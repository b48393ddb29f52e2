from dataclasses import replace

import numpy as np
import pytest

from exidyn.trajectories.clearances.collision import Collision
from exidyn.trajectories.errors import Infeasible
from exidyn.trajectories.kinds.rests import Workspace
from exidyn.trajectories.kinds.sweeps import constant_velocity_sweeps
from exidyn.trajectories.limits.check import check
from exidyn.trajectories.limits.leads import with_leads
from exidyn.trajectories.limits.usable_limits import usable

from ...parts.small import small_arm
from ...parts.small.two_joints import arm

pytestmark = pytest.mark.slow

LIMITS = arm().limits
TICK = 0.004
POSE = np.array([0.1, -0.3])


def cruises(sweeps, joint):
    """Velocity and duration of each time a joint moves without acceleration, as sampled on ticks."""
    states = sweeps.every(TICK)
    steady = (np.abs(states.acceleration[:, joint]) < 1e-9) & (np.abs(states.velocity[:, joint]) > 1e-6)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], steady, [False]]).astype(int)))
    spans = [(start, end) for start, end in zip(edges[::2], edges[1::2], strict=True)]
    found = []
    for start, end in spans:
        velocity = states.velocity[start:end, joint]
        found.append((velocity[0], (end - start) * TICK, np.ptp(velocity), states.position[start:end, joint]))
    return found


def passes(sweeps, joint, velocities):
    """The cruises at the velocities asked for, in their order."""
    found = cruises(sweeps, joint)
    return [[one for one in found if one[0] == pytest.approx(v, rel=1e-9)] for v in velocities]


SPEEDS = np.geomspace(0.03, 1.8, 6)
"""From a hundredth to six tenths of the velocity limit [rad/s]."""


def test_every_velocity_is_cruised_at_exactly_both_ways():
    sweeps = constant_velocity_sweeps(Workspace(LIMITS, TICK), [1], POSE)
    for velocity in SPEEDS:
        (forth,), (back,) = passes(sweeps, 1, [velocity, -velocity])
        for one in (forth, back):
            assert one[2] < 1e-12
            assert one[1] >= min(10.0, 4.0 / velocity) - 0.5
        assert np.ptp(forth[3]) == pytest.approx(np.ptp(back[3]), abs=1e-9)
        assert forth[3][0] == pytest.approx(back[3][-1], abs=2 * velocity * TICK)


def test_other_joints_rest_and_it_begins_and_ends_at_the_pose():
    sweeps = constant_velocity_sweeps(Workspace(LIMITS, TICK), [1], POSE)
    states = sweeps.every(TICK)
    np.testing.assert_array_equal(states.position[:, 0], POSE[0])
    for row in (0, -1):
        np.testing.assert_allclose(states.position[row], POSE, atol=1e-8)
        np.testing.assert_allclose([states.velocity[row], states.acceleration[row]], 0.0, atol=1e-8)


def test_default_speeds_span_the_bend_and_keep_a_second_of_cruise():
    sweeps = constant_velocity_sweeps(Workspace(LIMITS, TICK), [0, 1], POSE)
    for joint in (0, 1):
        found = passes(sweeps, joint, SPEEDS)
        assert [len(one) for one in found] == [1] * 6
        assert min(one[0][1] for one in found) >= 1.0
        assert max(one[0][1] for one in found) <= 10.0 + TICK


def test_a_narrow_range_makes_the_fastest_of_its_own_speeds_slower():
    narrow = replace(LIMITS, position_lower=np.array([-0.4, -2.5]), position_upper=np.array([0.4, 2.5]))
    sweeps = constant_velocity_sweeps(Workspace(narrow, TICK), [0], POSE)
    lasting = [one for one in cruises(sweeps, 0) if one[1] >= 0.99]
    fastest = max(abs(one[0]) for one in lasting)
    assert len(lasting) >= 12
    assert 0.5 < fastest < 0.8
    reached = sweeps.extremes().position
    assert reached.upper[0] <= 0.4 + 1e-9
    assert reached.lower[0] >= -0.4 - 1e-9


@pytest.mark.parametrize("tick", [0.002, 0.004, 0.012])
def test_all_limits_are_kept_with_leads_and_on_ticks(tick):
    one_way = replace(
        LIMITS, velocity_lower=np.array([-1.0, -2.0]), acceleration_lower=np.array([-5.0, -20.0])
    )
    sweeps = constant_velocity_sweeps(Workspace(one_way, tick), [0, 1], POSE)
    assert check(sweeps, one_way, tick) == []
    assert check(with_leads(sweeps, one_way, tick), one_way, tick) == []
    for part in sweeps.parts:
        assert part.duration / tick == pytest.approx(round(part.duration / tick), abs=1e-6)
    np.testing.assert_allclose(sweeps.at([sweeps.duration]).position[0], POSE, atol=1e-8)


def test_a_joint_sweeps_only_where_the_arm_is_clear(tmp_path):
    robot, geometry = small_arm.small_arm(tmp_path)
    collision, limits = Collision.of(robot, geometry), usable(robot).limits
    pose = np.array([0.0, 0.6, 0.8, 0.1, 0.0])
    sweeps = constant_velocity_sweeps(Workspace(limits, TICK, [collision]), [0, 1, 2], pose)
    nearest = collision.worst(sweeps)
    assert nearest.allowed
    assert check(sweeps, limits, TICK) == []
    free = constant_velocity_sweeps(Workspace(limits, TICK), [0, 1, 2], pose)
    assert not collision.worst(free).allowed


def test_the_clear_range_ends_near_where_something_is_in_contact(tmp_path):
    robot, geometry = small_arm.small_arm(tmp_path)
    collision, limits = Collision.of(robot, geometry), usable(robot).limits
    pose = np.array([0.0, 0.6, 0.8, 0.1, 0.0])
    bounds = Workspace(limits, TICK, [collision]).clear_range(pose, 1)
    positions = np.tile(pose, (2001, 1))
    positions[:, 1] = np.linspace(*bounds, 2001)
    assert np.min(collision.margins(positions)) >= 0.0
    wide = (limits.position_lower[1], limits.position_upper[1])
    narrowed = [abs(b - w) > 1e-9 for b, w in zip(bounds, wide, strict=True)]
    assert any(narrowed)
    for bound, cut in zip(bounds, narrowed, strict=True):
        if cut:
            outside = pose.copy()
            outside[1] = bound + 0.06 * np.sign(bound - pose[1])
            assert np.min(collision.margins(outside[None])) < 0.0


def test_a_joint_without_room_to_cruise_is_refused():
    narrow = replace(LIMITS, position_lower=np.array([-2.5, 0.5]), position_upper=np.array([2.5, 0.51]))
    with pytest.raises(Infeasible, match="joint 2: from 0.5 to 0.51 rad there is no room to cruise"):
        constant_velocity_sweeps(Workspace(narrow, TICK), [1], np.array([0.1, 0.505]))
