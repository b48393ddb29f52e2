"""One start of the search: better, inside, and with an answer whenever it ends."""

import time
from dataclasses import dataclass, replace

import numpy as np
import pytest

from exidyn.identification.effects import MotionGradient
from exidyn.trajectories.search.goals import Objective
from exidyn.trajectories.search.problem import Problem, kinematic_bounds
from exidyn.trajectories.search.solve import TOLERANCE, Budget, solve

from ...parts.plans.excitation import coefficients, goal, limits, small_basis

pytestmark = pytest.mark.numerical


@pytest.fixture(scope="module")
def problem():
    kept = limits()
    basis = small_basis(harmonics=2)
    objectives = goal().objectives(kept, basis.period / basis.samples)
    return Problem(basis, objectives, kinematic_bounds(kept), 2, np.ones(2))


@pytest.fixture(scope="module")
def start(problem):
    """Slow, and so inside."""
    return problem.unknowns(coefficients(problem.basis, 2, size=0.1))


def value(problem, unknowns):
    return problem.objectives[-1].value(problem.basis.motion(problem.coefficients(unknowns)))


def inside(problem, unknowns):
    return np.min(problem.margins(unknowns)[0]) >= -TOLERANCE


@pytest.fixture(scope="module")
def searched(problem, start):
    """The search, and the value of each improvement."""
    values = []
    return solve(problem, start, report=lambda search: values.append(search.value)), values


@pytest.fixture(scope="module")
def search(searched):
    return searched[0]


def test_it_finds_better_and_stays_inside(problem, start, searched):
    search, values = searched
    assert inside(problem, start)
    assert inside(problem, search.unknowns)
    assert search.value < value(problem, start) - 0.5
    assert search.value == pytest.approx(value(problem, search.unknowns), rel=1e-12)
    assert np.all(np.diff(values) < 0)
    assert values[-1] == search.value


def test_what_it_ends_at_is_a_minimum(problem, search):
    """No small step that keeps to the bounds makes it better by more than the tolerance of the solver."""
    random, better, tried = np.random.default_rng(0), 0, 0
    room = np.min(problem.margins(search.unknowns)[0])
    for _ in range(1000):
        step = search.unknowns + 1e-3 * random.normal(size=search.unknowns.size)
        if np.min(problem.margins(step)[0]) >= room:
            tried += 1
            better += value(problem, step) < search.value - 1e-3
    assert tried > 3
    assert better == 0


def test_the_same_start_gives_the_same(problem, start, search):
    again = solve(problem, start)
    np.testing.assert_array_equal(again.unknowns, search.unknowns)
    np.testing.assert_array_equal(again.curvature, search.curvature)


def test_a_start_outside_is_brought_inside(problem):
    far = problem.unknowns(coefficients(problem.basis, 2, size=1.0))
    assert not inside(problem, far)
    found = solve(problem, far)
    assert inside(problem, found.unknowns)
    assert np.isfinite(found.value)
    found = solve(problem, far, Budget(stop=lambda: True))  # nothing was inside, so nothing is returned
    assert (found.unknowns, found.value) == (None, np.inf)


@pytest.mark.parametrize(
    "options",
    [{"budget": Budget(stop=lambda: True)}, {"until": 0.0}],
    ids=["stopped", "no time"],
)
def test_asked_to_end_at_once_it_ends_with_its_start(problem, start, options):
    found = solve(problem, start, **options)
    np.testing.assert_array_equal(found.unknowns, start)
    assert found.value == pytest.approx(value(problem, start), rel=1e-12)
    np.testing.assert_array_equal(found.curvature, np.eye(len(start)))


def test_asked_to_stop_on_the_way_it_ends_with_the_best(problem, start, search):
    reports = []
    budget = Budget(stop=lambda: len(reports) >= 4)
    found = solve(problem, start, budget, report=lambda s: reports.append(s.value))
    assert len(reports) == 4
    assert found.value == reports[-1] == min(reports)
    assert search.value < found.value < value(problem, start)
    assert inside(problem, found.unknowns)


def test_a_clock_that_runs_out_ends_it(problem, start, search, monkeypatch):
    now, times = iter(np.arange(0.0, 1e6)), []
    monkeypatch.setattr(time, "monotonic", lambda: next(now))
    budget = Budget()
    found = solve(problem, start, budget, until=8.0, report=lambda _: times.append(budget.used))
    assert inside(problem, found.unknowns)
    assert search.value < found.value <= value(problem, start)
    assert times[-1] <= 9.0


@dataclass(eq=False)
class Counting(Objective):
    """An objective that counts its calls and those of its gradient, and is interrupted after so many."""

    inner: object
    smooth: bool = True
    interrupted: float = np.inf
    values: int = 0
    gradients: int = 0

    def __call__(self, motion):
        self.values += 1
        if self.values > self.interrupted:
            raise KeyboardInterrupt
        value, gradient = self.inner(motion)

        def counted():
            self.gradients += 1
            return gradient()

        return value, counted

    def value(self, motion):
        return self.inner.value(motion)


def test_an_interrupt_keeps_the_best(problem, start):
    interrupting = Counting(problem.objectives[-1], interrupted=5)
    found = solve(replace(problem, objectives=[interrupting]), start)
    assert interrupting.values == 6
    assert inside(problem, found.unknowns)
    assert found.value == pytest.approx(value(problem, found.unknowns), rel=1e-12)


def test_what_is_not_smooth_judges_and_is_not_followed(problem, start):
    stand_in, goal_itself = problem.objectives[-2:]
    assert (stand_in.smooth, goal_itself.smooth) == (True, False)
    judged = Counting(goal_itself, smooth=False)
    found = solve(replace(problem, objectives=[stand_in, judged]), start)
    assert judged.gradients == 0
    assert found.value == pytest.approx(value(problem, found.unknowns), rel=1e-12)
    assert replace(problem, objectives=[stand_in, judged]).last().objectives == [stand_in, judged]
    assert replace(problem, objectives=[stand_in]).last().objectives == [stand_in]


def test_steps_of_a_line_search_need_no_gradient(problem, start):
    counting = Counting(problem.objectives[-2])
    solve(replace(problem, objectives=[counting]), start)
    assert 0 < counting.gradients < counting.values


@dataclass(eq=False)
class Hole(Objective):
    """An objective that is no number far from its start."""

    def __call__(self, motion):
        none = MotionGradient.none(motion.position.shape)
        return self.value(motion), lambda: replace(none, position=-np.ones(motion.position.shape))

    def value(self, motion):
        return float(-np.sum(motion.position)) if motion.position.max() < 0.5 else np.nan


def test_an_objective_that_is_no_number_somewhere_spoils_nothing(problem):
    start = problem.unknowns(coefficients(problem.basis, 2, size=0.02))
    found = solve(replace(problem, objectives=[Hole()]), start)
    assert np.all(np.isfinite(found.unknowns))
    assert np.isfinite(found.value)


def test_each_objective_starts_where_the_last_ended(problem, start, search):
    first = solve(replace(problem, objectives=problem.objectives[:1]), start)
    assert search.value <= value(problem, first.unknowns) + 1e-3
