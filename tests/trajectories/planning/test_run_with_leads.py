"""A whole run: rest, lead-in, periods, lead-out, rest, joined and inside every limit."""

import contextlib
from dataclasses import replace

import numpy as np
import pytest

from exidyn.trajectories.clearances.region import Region, box
from exidyn.trajectories.errors import Infeasible
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.limits.check import check
from exidyn.trajectories.limits.leads import with_leads
from exidyn.trajectories.planning.planner import whole_run
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.search.delivery import inside_kinematics
from exidyn.trajectories.search.torque_bound import TorqueBound

from ...parts.plans.excitation import TICK, core, limits
from ...parts.small import two_joints

pytestmark = pytest.mark.slow

JOIN = 1e-6
FLOOR = Region.of(two_joints.arm(), "flange", box([-9.0, -9.0, -0.5], [9.0, 9.0, 9.0]))


def series(share=0.8, seed=0):
    random = np.random.default_rng(seed)
    motion = Fourier(4.0, np.array([0.2, -0.3]), *random.normal(size=(2, 2, 3)) / [1, 2, 3])
    return inside_kinematics(motion, limits(), share)


def moving(run):
    """Duration without the rests, which fill the run [s]."""
    return sum(part.duration for part in run.parts[1:-1])


def wishes(**options):
    """Options of a run of one period, if there are no others."""
    return Wishes(**{"tick": TICK, "seconds": 7.2} | options)


@pytest.mark.parametrize("seed", range(2))
def test_it_begins_and_ends_at_rest_joins_and_keeps_to_all_limits(seed):
    torque = TorqueBound(two_joints.model(), limits().torque).of("")
    run = whole_run(series(0.99, seed), limits(), wishes(seconds=15.2, rest=0.5), [torque])
    assert not check(run, limits(), TICK, torque)
    ends = run.at(np.array([0.0, 0.5, run.duration - 0.5, run.duration]))
    assert not np.any([ends.velocity, ends.acceleration])
    np.testing.assert_allclose(ends.position, np.tile(ends.position[0], (4, 1)), atol=JOIN)
    for time in run.begins[1:-1]:
        before, after = run.at(np.array([time - 1e-9])), run.at(np.array([time]))
        np.testing.assert_allclose(before[1:4], after[1:4], atol=1e-5)
    ticks = run.begins / TICK
    np.testing.assert_allclose(ticks, np.round(ticks), atol=1e-6)


def test_the_periods_are_those_of_the_series_from_another_moment():
    given = series()
    run = whole_run(given, limits(), wishes(seconds=15.2))
    found = core(run)
    assert (found.period, found.periods) == (4.0, 3)
    radius = np.hypot(given.sine, given.cosine)
    np.testing.assert_allclose(np.hypot(found.sine, found.cosine), radius, rtol=1e-9)
    np.testing.assert_array_equal(found.centre, given.centre)
    for kind in range(4):
        np.testing.assert_allclose(found.extremes()[kind][:2], given.extremes()[kind][:2], atol=1e-6)


def test_it_begins_and_ends_at_the_pose_that_was_asked_for_clear_of_a_region():
    start = np.array([-1.5, 0.0])
    run = whole_run(series(0.3), limits(), wishes(seconds=9.2, start=start, clearances=[FLOOR]))
    assert FLOOR.worst(run).allowed
    for time in (0.0, 1.0, run.duration):
        np.testing.assert_allclose(run.at(np.array([time])).position[0], start, atol=JOIN)


def test_leads_are_the_shortest_of_the_moments_tried():
    """Forty of the period, a whole number of ticks from its beginning; at half of acceleration and jerk."""
    given, durations = series(), []
    kept = limits()
    half = replace(kept, jerk=0.5 * kept.jerk, acceleration=0.5 * kept.acceleration)
    half = replace(half, acceleration_lower=0.5 * kept.acceleration_lower)
    for shift in np.round(np.linspace(0.0, 4.0, 40, endpoint=False) / TICK) * TICK:
        with contextlib.suppress(Infeasible):
            durations.append(moving(with_leads(given.shifted(shift), half, TICK)))
    assert len(durations) > 20
    run = whole_run(given, kept, wishes())
    assert moving(run) == pytest.approx(min(durations), abs=1e-9)
    assert run.duration == pytest.approx(7.2, abs=1e-9)
    for lead in (run.parts[1], run.parts[3]):
        assert np.all(lead.extremes().jerk.upper <= half.jerk * (1 + 1e-9))
    assert max(durations) > min(durations) + 0.2


def test_leads_are_gentler_where_the_drives_are_weak():
    """At full acceleration they ask 58 N m of the shoulder, and the motion itself 38."""
    kept = replace(limits(), torque=np.array([48.0, 190.0]))
    torque = TorqueBound(two_joints.model(), kept.torque).of("")
    start, slow = np.array([0.3, -0.3]), series(0.1)
    free = whole_run(slow, kept, wishes(seconds=9.2, start=start))
    assert {violation.kind for violation in check(free, kept, TICK, torque)} == {"torque"}
    gentle = whole_run(slow, kept, wishes(seconds=9.2, start=start), [torque])
    assert not check(gentle, kept, TICK, torque)
    assert moving(gentle) > moving(free)


@pytest.mark.parametrize(
    ("torque", "options", "message"),
    [
        ([20.0, 190.0], {}, "no lead into the motion keeps to the limits: joint 1: torque"),
        ([90.0, 190.0], {"start": [2.6, 0.0]}, "joint 1: the lead"),
        ([90.0, 190.0], {"start": [1.5, 0.0]}, r"no lead into the motion.* flange z >= .* mm of room at"),
    ],
)
def test_a_start_that_cannot_be_left_is_reported(torque, options, message):
    options = {"clearances": [FLOOR]} | {name: np.array(value) for name, value in options.items()}
    kept = replace(limits(), torque=np.array(torque))
    bound = TorqueBound(two_joints.model(), kept.torque).of("")
    with pytest.raises(Infeasible, match=message):
        whole_run(series(0.1), kept, wishes(seconds=9.2, **options), [bound])
