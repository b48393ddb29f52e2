"""The search as a whole: starts inside, better ends, the best of several, and errors with their reasons."""

import threading
from dataclasses import replace
from itertools import count

import numpy as np
import pytest

from exidyn.identification.arm.robot import Limits, Robot
from exidyn.trajectories.clearances.region import Region, box
from exidyn.trajectories.errors import BadLimits, Infeasible
from exidyn.trajectories.limits.check import check
from exidyn.trajectories.limits.usable_limits import ranges, usable
from exidyn.trajectories.search import delivery
from exidyn.trajectories.search.clock import IterationClock
from exidyn.trajectories.search.criteria import volume
from exidyn.trajectories.search.delivery import FINE, Delivery
from exidyn.trajectories.search.excite import excite, starts_of
from exidyn.trajectories.search.problem import Basis
from exidyn.trajectories.search.shrink import tightened, violations_of
from exidyn.trajectories.search.start import (
    best_of_tries,
    largest_coefficients,
    one_start,
    problem_of,
    random_start,
)
from exidyn.trajectories.search.torque_bound import TorqueBound

from ...parts.plans.excitation import TICK, goal, limits, setting, smooth_model
from ...parts.runs.robots import kinematics
from ...parts.small import two_joints

pytestmark = pytest.mark.slow

NEVER = 1e6
"""Seconds that no search here takes."""


QUICK = goal(criterion=volume)
"""One objective in place of four, where it does not matter which."""


def never():
    return False


@pytest.fixture
def here(monkeypatch):
    """Starts one after the other in this process, whatever the number of cores."""

    def run_here(work, tasks, seconds, note, receive):
        for task in tasks:
            note(work(*task, seconds, never))

    monkeypatch.setattr("exidyn.trajectories.search.excite.run_all", run_here)


def region():
    return Region.of(two_joints.arm(), "flange", box([-0.6, -1.0, -0.3], [0.75, 1.0, 0.3]))


def delivered(of, within, basis, coefficients):
    delivery = Delivery(of, within, basis, lambda _: None)
    delivery.offer(coefficients)
    return delivery.best(0)


@pytest.fixture(scope="module")
def found():
    return one_start(goal(), setting(), 3, NEVER, never)


def nothing_violated(one, of, kept, clearances=()):
    for series in one.series:
        assert not check(series, kept, TICK, TorqueBound(of.model, kept.torque).of(""))
        for clearance in clearances:
            assert clearance.worst(series).allowed


def test_it_is_better_than_its_start_and_inside(found):
    of, within = goal(), setting()
    problem = problem_of(of, within, 4.0)
    start = random_start(of, within, problem.basis, 3)
    begun = delivered(of, within, problem.basis, start)
    assert found.value < begun.value - 0.3
    assert found.seed == 3
    nothing_violated(found, of, limits())
    assert found.series[0].period == 4.0
    assert found.series[0].harmonics == 2


def test_what_is_reported_on_the_way_is_delivered_and_no_series_passes_a_limit_twice():
    reported = []
    one = one_start(goal(), setting(), 1, NEVER, never, reported.append)
    assert reported == sorted(reported, reverse=True)
    assert one.value == reported[-1]
    assert [value for _, value in one.history] == reported


def test_limits_are_tightened_by_what_was_passed():
    of, kept = goal(), limits()
    problem = problem_of(of, setting(), 4.0)
    (series,) = problem.basis.fourier(random_start(of, setting(), problem.basis, 3))
    large = series.scaled(1.5)
    beyond = violations_of(large, of, kept, TICK)
    nearer = tightened(kept, beyond)
    for what, joint, _, value, limit in beyond:
        if what in ("velocity", "acceleration", "jerk", "torque"):
            lower = what in ("velocity", "acceleration") and value < 0
            now = getattr(nearer, f"{what}_lower" if lower else what)[joint]
            assert abs(now) <= abs(limit * limit / value) * (1 + 1e-9)
    assert beyond
    assert np.all(nearer.position_upper <= kept.position_upper)


def test_its_value_is_that_of_the_criterion_at_fine_samples_with_friction_as_stated(found):
    of = goal()
    motion = found.series[0].at(np.arange(0.0, 4.0, FINE)).motion()
    expected = of.objectives(limits(), 0.0)[-1].value(motion)
    assert found.value == pytest.approx(expected, rel=1e-9)


@pytest.fixture
def at_the_end_alone(monkeypatch):
    """Nothing is delivered on the way, as which series are depends on the clock."""
    monkeypatch.setattr(delivery, "ASIDE", 0.0)


@pytest.mark.usefixtures("at_the_end_alone")
def test_the_same_seed_gives_the_same_and_another_another():
    one, again, other = (one_start(QUICK, setting(), seed, NEVER, never) for seed in (3, 3, 4))
    np.testing.assert_array_equal(again.series[0].sine, one.series[0].sine)
    assert again.value == one.value
    assert not np.allclose(other.series[0].sine, one.series[0].sine)


@pytest.mark.parametrize("series", [1, 2])
def test_starts_keep_to_ninety_per_cent_and_differ(series):
    basis = Basis(4.0, 2, 40, series)
    start = random_start(goal(), setting(series=series), basis, 0)
    every = basis.fourier(start)
    for one in every:
        assert not check(one.scaled(1 / 0.9 - 1e-9), replace(limits(), torque=np.full(2, np.inf)), TICK)
        found, kept = one.extremes(), limits()
        shares = [found.velocity.upper / kept.velocity, found.acceleration.upper / kept.acceleration]
        shares += [found.position.upper / kept.position_upper, found.jerk.upper / kept.jerk]
        shares += [-found.velocity.lower / kept.velocity, -found.acceleration.lower / kept.acceleration]
        shares += [found.position.lower / kept.position_lower, -found.jerk.lower / kept.jerk]
        np.testing.assert_allclose(np.max(shares, axis=0), 0.9, rtol=1e-6)
    assert series == 1 or not np.allclose(every[0].sine, every[1].sine)


def test_each_coefficient_alone_at_its_largest_just_keeps_to_the_limits():
    kept = limits()
    basis = Basis(4.0, 3, 60, 2)
    largest = largest_coefficients(basis, kept)
    assert largest.shape == (basis.rows, 2)
    for row in range(basis.rows):
        states = basis.states(np.where(np.arange(basis.rows)[:, None] == row, largest, 0.0))
        room = 0.5 * (kept.position_upper - kept.position_lower)
        shares = [np.abs(states.position) / room] + [
            np.abs(one) / np.minimum(-lower, upper)
            for one, (lower, upper) in zip(
                (states.velocity, states.acceleration, states.jerk),
                list(ranges(kept).values())[1:],
                strict=True,
            )
        ]
        np.testing.assert_allclose(np.max(shares, axis=(0, 1)), 1.0, rtol=0.02)


def test_several_series_are_planned_together_and_complement_each_other():
    """Two of four seconds are no less informative than one."""
    within = setting(series=2, harmonics=1)
    both = one_start(QUICK, within, 0, NEVER, never)
    assert len(both.series) == 2
    nothing_violated(both, QUICK, limits())
    assert not np.allclose(both.series[0].sine, both.series[1].sine, atol=0.01)
    alone = one_start(QUICK, setting(harmonics=1), 0, NEVER, never)
    assert both.value < alone.value


def test_clearances_hold_between_samples():
    within = setting(clearances=(region(),), limits=replace(limits(), torque=np.full(2, np.inf)))
    one = one_start(QUICK, within, 0, NEVER, never)
    nothing_violated(one, QUICK, within.limits, within.clearances)
    free = one_start(QUICK, setting(), 0, NEVER, never)
    assert not region().worst(free.series[0]).allowed


def test_stopped_at_once_it_still_has_its_start():
    one = one_start(goal(), setting(), 0, NEVER, lambda: True)
    nothing_violated(one, goal(), limits())
    assert np.isfinite(one.value)


@pytest.mark.usefixtures("at_the_end_alone", "here")
def test_the_best_of_several_starts_is_returned_and_all_are_reported():
    text = []
    best = excite(QUICK, setting(), starts=2, seed=3, seconds=NEVER, progress=text.append)
    singles = [one_start(QUICK, setting(), seed, NEVER, never) for seed in (3, 4)]
    assert best.value == min(one.value for one in singles)
    assert best.seed == min(singles, key=lambda one: one.value).seed
    assert [line.split(":")[0] for line in text] == [f"start {k} of 2" for k in (1, 2)]
    assert text[-1].endswith(f", best {np.exp(best.value):.4g}")


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("cores", [1, 4])
def test_a_search_of_iterations_is_the_same_on_a_slow_computer(monkeypatch, cores):
    search = {"starts": 2, "seed": 3, "iterations": 40}
    expected = excite(goal(), setting(), **search)
    monkeypatch.setattr("os.cpu_count", lambda: cores)
    monkeypatch.setattr("exidyn.trajectories.search.clock.time.monotonic", count(step=100.0).__next__)
    slow = excite(goal(), setting(), **search)
    assert slow.value == expected.value
    np.testing.assert_array_equal(slow.series[0].sine, expected.series[0].sine)
    assert max(used for used, _ in expected.history) <= 40 + 2 * IterationClock.offer


def test_more_iterations_give_a_better_motion():
    few, many = (one_start(goal(), setting(), 3, n, never, clock=IterationClock()) for n in (5, 60))
    assert many.value < few.value


def test_starts_take_the_periods_in_turn():
    within = setting(periods=(4.0, 3.0))
    found = [one_start(goal(), within, seed, 0.0, never).series[0].period for seed in (0, 1, 2)]
    assert found == [4.0, 3.0, 4.0]


def test_a_search_that_no_start_fits_gives_the_reason(monkeypatch):
    nowhere = Region.of(two_joints.arm(), "flange", box([2.0, -1.0, -1.0], [3.0, 1.0, 1.0]))
    text = []
    with pytest.raises(Infeasible, match=r"no position within the joint limits .* violates flange x >= 2 m"):
        excite(goal(), setting(clearances=(nowhere,)), starts=1, progress=text.append)
    assert text == []


def test_too_heavy_to_hold_is_reported():
    weak = replace(limits(), torque=np.array([20.0, 190.0]))
    reason = one_start(goal(), setting(limits=weak), 0, 0.0, never)
    assert "shoulder: torque" in reason
    with pytest.raises(Infeasible, match="shoulder: torque"):
        excite(goal(), setting(limits=weak), starts=1, seconds=1e-3)


@pytest.mark.parametrize(("wrong", "words"), [({"starts": 0}, "0 starts"), ({"seconds": -1.0}, "in -1 s")])
def test_a_search_of_nothing_is_refused(wrong, words):
    with pytest.raises(BadLimits, match=words):
        excite(goal(), setting(), **wrong)
    with pytest.raises(BadLimits, match="in nan s"):
        excite(goal(), setting(), seconds=np.nan)
    with pytest.raises(BadLimits, match="iterations: 0"):
        excite(goal(), setting(), iterations=0)
    with pytest.raises(BadLimits, match="seed: -1"):
        excite(goal(), setting(), seed=-1)


def test_without_torque_limits_there_is_no_torque_bound():
    free = replace(limits(), torque=np.full(2, np.inf))
    kinds = [type(b) for b in problem_of(goal(), setting(limits=free), 4.0).bounds]
    assert TorqueBound not in kinds
    assert TorqueBound in [type(b) for b in problem_of(goal(), setting(), 4.0).bounds]


@pytest.mark.parametrize("joints", ["r", "pr"])
def test_arms_of_one_joint_and_of_slides(joints):
    n = len(joints)
    bounds = Limits(*np.outer([-1.0, 1.0, 2.0, 8.0, 100.0, 2000.0], np.ones(n)))
    robot = Robot("other", kinematics(joints), limits=bounds)
    kept = usable(robot).limits
    of = goal(replace(smooth_model(), robot=robot), criterion=volume)
    one = one_start(of, setting(limits=kept), 0, NEVER, never)
    nothing_violated(one, of, kept)


@pytest.mark.parametrize(
    ("seconds", "cores", "count"),
    [(1.0, 2, 2), (5.0, 2, 2), (8.0, 2, 3), (40.0, 2, 4), (5.0, 8, 4), (5.0, 1, 1), (20.0, 1, 4)],
)
def test_there_are_as_many_starts_as_the_time_is_worth(seconds, cores, count, monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: cores)
    within = setting(periods=(8.0, 6.0, 4.0))
    found = starts_of(within, 4, 7, seconds)
    assert [one.periods for one, _ in found] == [(8.0,), (8.0,), (6.0,), (4.0,)][:count]
    assert [seed for _, seed in found] == [7, 8, 9, 10][:count]


def test_a_start_goes_on_from_the_best_of_its_tries(monkeypatch):
    problem = problem_of(goal(), setting(), 4.0)

    def reached(tries):
        monkeypatch.setattr("exidyn.trajectories.search.start.TRIES", tries)
        best, _ = best_of_tries(goal(), setting(), problem, 5, NEVER, never)
        return problem.value(problem.unknowns(best), problem.objectives[0])[0]

    alone = random_start(goal(), setting(), problem.basis, 5)
    values = [reached(tries) for tries in (1, 2, 6)]
    assert values[0] < problem.value(problem.unknowns(alone), problem.objectives[0])[0]
    assert values[2] < values[0]
    assert values == sorted(values, reverse=True)


def test_without_time_for_a_try_a_start_is_as_drawn():
    problem = problem_of(goal(), setting(), 4.0)
    found, curvature = best_of_tries(goal(), setting(), problem, 5, 0.0, never)
    assert curvature is None
    np.testing.assert_array_equal(found, random_start(goal(), setting(), problem.basis, 5))


def test_a_stop_from_another_thread_ends_a_search_of_hours(monkeypatch):
    """What a graphical program does: searches in a thread, and asks it to end."""
    monkeypatch.setattr("exidyn.trajectories.search.solve.STEPS", 10**6)
    asked, begun = threading.Event(), []

    def stop():
        begun.append(1)
        if len(begun) > 5:
            asked.set()
        return asked.is_set()

    one = one_start(goal(), setting(), 0, NEVER, stop)
    assert len(begun) <= 10  # asked once more between the parts of a search
    nothing_violated(one, goal(), limits())
