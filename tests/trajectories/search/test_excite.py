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
from exidyn.trajectories.search.delivery import FINE, Delivery
from exidyn.trajectories.search.excite import (
    best_of_tries,
    excite,
    largest_coefficients,
    one_start,
    problem_of,
    random_start,
    starts_of,
)
from exidyn.trajectories.search.goals import volume
from exidyn.trajectories.search.problem import Basis
from exidyn.trajectories.search.solve import Budget, IterationBudget

from ...parts.plans import excitation
from ...parts.plans.excitation import TICK, goal, kinematic_share, limits, setting, smooth_model
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
            note(work(*task, seconds, never, lambda value: None))

    monkeypatch.setattr("exidyn.trajectories.search.excite.run_all", run_here)


def region():
    return Region.of(two_joints.arm(), "flange", box([-0.6, -1.0, -0.3], [0.75, 1.0, 0.3]))


def delivered(of, within, basis, coefficients):
    delivery = Delivery(of, within, basis, Budget(), lambda _: None)
    delivery.offer(coefficients)
    return delivery.best(0)


def nothing_violated(one, of, kept, clearances=()):
    for series in one.series:
        excitation.nothing_violated(series, of, kept, clearances)


def test_it_is_better_than_its_start_and_inside_and_reports_its_way():
    of, within, reported = goal(), setting(), []
    found = one_start(of, within, 3, Budget(), reported.append)
    problem = problem_of(of, within, 4.0)
    begun = delivered(of, within, problem.basis, random_start(of, within, problem.basis, 3))
    assert found.value < begun.value - 0.3
    nothing_violated(found, of, limits())
    assert (found.seed, found.series[0].period, found.series[0].harmonics) == (3, 4.0, 2)
    assert reported == sorted(reported, reverse=True) == [value for _, value in found.history]
    assert found.value == reported[-1]
    motion = found.series[0].at(np.arange(0.0, 4.0, FINE)).motion()  # with friction as stated
    assert found.value == pytest.approx(of.objectives(limits(), 0.0)[-1].value(motion), rel=1e-9)


@pytest.fixture
def at_the_end_alone(monkeypatch):
    """Nothing is delivered on the way, as which series are depends on the clock."""
    monkeypatch.setattr(delivery, "ASIDE", 0.0)


def test_starts_keep_to_ninety_per_cent_and_differ():
    basis = Basis(4.0, 2, 40, 2)
    every = basis.fourier(random_start(goal(), setting(series=2), basis, 0))
    for one in every:
        assert not check(one.scaled(1 / 0.9 - 1e-9), replace(limits(), torque=np.full(2, np.inf)), TICK)
        np.testing.assert_allclose(kinematic_share(one, limits()), 0.9, rtol=1e-6)
    assert not np.allclose(every[0].sine, every[1].sine)


def test_each_coefficient_alone_at_its_largest_just_keeps_to_the_limits():
    kept, basis = limits(), Basis(4.0, 3, 60, 2)
    largest = largest_coefficients(basis, kept)
    room = [0.5 * (upper - lower) for lower, upper in list(ranges(kept).values())[:4]]
    assert largest.shape == (basis.rows, 2)
    for row in range(basis.rows):
        states = basis.states(np.where(np.arange(basis.rows)[:, None] == row, largest, 0.0))
        shares = [np.abs(rate) / width for rate, width in zip(states[1:5], room, strict=True)]
        np.testing.assert_allclose(np.max(shares, axis=(0, 1)), 1.0, rtol=0.02)


def test_several_series_are_planned_together_and_complement_each_other():
    """Two of four seconds are no less informative than one."""
    within = setting(series=2, harmonics=1)
    both = one_start(QUICK, within, 0, Budget())
    assert len(both.series) == 2
    nothing_violated(both, QUICK, limits())
    assert not np.allclose(both.series[0].sine, both.series[1].sine, atol=0.01)
    alone = one_start(QUICK, setting(harmonics=1), 0, Budget())
    assert both.value < alone.value


def test_clearances_hold_between_samples():
    within = setting(clearances=(region(),), limits=replace(limits(), torque=np.full(2, np.inf)))
    one = one_start(QUICK, within, 0, Budget())
    nothing_violated(one, QUICK, within.limits, within.clearances)
    free = one_start(QUICK, setting(), 0, Budget())
    assert not region().worst(free.series[0]).allowed


@pytest.mark.usefixtures("at_the_end_alone", "here")
def test_the_best_of_several_starts_is_returned_and_all_are_reported():
    text = []
    best = excite(QUICK, setting(), starts=2, seed=3, seconds=NEVER, progress=text.append)
    singles = [one_start(QUICK, setting(), seed, Budget()) for seed in (3, 4)]
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
    monkeypatch.setattr("exidyn.trajectories.search.solve.time.monotonic", count(step=100.0).__next__)
    slow = excite(goal(), setting(), **search)
    assert slow.value == expected.value
    np.testing.assert_array_equal(slow.series[0].sine, expected.series[0].sine)
    assert max(used for used, _ in expected.history) <= 40 + 2 * IterationBudget.offer


def test_a_search_that_no_start_fits_gives_the_reason():
    nowhere = Region.of(two_joints.arm(), "flange", box([2.0, -1.0, -1.0], [3.0, 1.0, 1.0]))
    text = []
    with pytest.raises(Infeasible, match=r"no position within the joint limits .* violates flange x >= 2 m"):
        excite(goal(), setting(clearances=(nowhere,)), starts=1, progress=text.append)
    assert text == []
    weak = replace(limits(), torque=np.array([20.0, 190.0]))
    with pytest.raises(Infeasible, match="shoulder: torque"):
        excite(goal(), setting(limits=weak), starts=1, seconds=1e-3)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"starts": 0}, "0 starts"),
        ({"seconds": -1.0}, "in -1 s"),
        ({"seconds": np.nan}, "in nan s"),
        ({"iterations": 0}, "iterations: 0"),
        ({"seed": -1}, "seed: -1"),
    ],
)
def test_a_search_of_nothing_is_refused(wrong, words):
    with pytest.raises(BadLimits, match=words):
        excite(goal(), setting(), **wrong)


@pytest.mark.parametrize("joints", ["r", "pr"])
def test_arms_of_one_joint_and_of_slides(joints):
    n = len(joints)
    bounds = Limits(*np.outer([-1.0, 1.0, 2.0, 8.0, 100.0, 2000.0], np.ones(n)))
    robot = Robot("other", kinematics(joints), limits=bounds)
    kept = usable(robot).limits
    of = goal(replace(smooth_model(), robot=robot), criterion=volume)
    one = one_start(of, setting(limits=kept), 0, Budget())
    nothing_violated(one, of, kept)


@pytest.mark.parametrize(
    ("seconds", "cores", "count"), [(1.0, 2, 2), (8.0, 2, 3), (40.0, 2, 4), (5.0, 8, 4), (5.0, 1, 1)]
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
        monkeypatch.setattr("exidyn.trajectories.search.excite.TRIES", tries)
        best, _ = best_of_tries(goal(), setting(), problem, 5, Budget())
        return problem.value(problem.unknowns(best), problem.objectives[0])[0]

    alone = random_start(goal(), setting(), problem.basis, 5)
    values = [reached(tries) for tries in (1, 2, 6)]
    assert values[0] < problem.value(problem.unknowns(alone), problem.objectives[0])[0]
    assert values[2] < values[0]
    assert values == sorted(values, reverse=True)
    found, curvature = best_of_tries(goal(), setting(), problem, 5, Budget(0.0))  # no time for a try
    assert curvature is None
    np.testing.assert_array_equal(found, alone)


def test_a_stop_from_another_thread_ends_a_search_of_hours(monkeypatch):
    """What a graphical program does: searches in a thread, and asks it to end."""
    monkeypatch.setattr("exidyn.trajectories.search.solve.STEPS", 10**6)
    asked, begun = threading.Event(), []

    def stop():
        begun.append(1)
        if len(begun) > 5:
            asked.set()
        return asked.is_set()

    one = one_start(goal(), setting(), 0, Budget(stop=stop))
    assert len(begun) <= 10  # asked once more between the parts of a search
    nothing_violated(one, goal(), limits())


def test_starts_take_the_periods_in_turn():
    within = setting(periods=(4.0, 3.0))
    assert [one_start(QUICK, within, seed, Budget(0.0)).series[0].period for seed in (0, 1, 2)] == [
        4.0,
        3.0,
        4.0,
    ]
