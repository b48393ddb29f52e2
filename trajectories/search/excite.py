"""Excite: the search for the Fourier series that is best for a goal within the limits.

A start goes from random coefficients to series inside all limits; the best of several starts is the result.
"""

import os
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import clear_position
from ..errors import BadLimits, Infeasible
from ..families.fourier import Fourier
from ..limits.usable_limits import ranges
from .delivery import Delivery, SearchResult, Setting, inside_kinematics, tightened, violations_of
from .experiment import design_model
from .goals import Goal
from .parallel import Report, Stop, run_all
from .problem import Basis, ClearanceBound, Problem, kinematic_bounds
from .solve import Budget, IterationBudget, Search, solve
from .torque_bound import TorqueBound

PAUSE = 5.0
"""Least time between two progress messages during a search [s]."""
SETTLES = 5.0
"""Time that one start needs on a core to come within a few percent of its final value [s]; with less time per
start there are fewer starts, but at least one per core."""


def excite(
    goal: Goal,
    setting: Setting,
    *,
    starts: int = 4,
    seed: int = 0,
    seconds: float = 60.0,
    iterations: int | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> SearchResult:
    """The best result of several starts, with the options of `plan`.

    Raises:
        BadLimits: The number of starts or iterations or the duration is not positive, or the seed is
            negative.
        Infeasible: No start could be brought inside the limits.
    """
    if starts < 1 or not seconds > 0.0:
        raise BadLimits(f"a search of {starts} starts in {seconds:g} s; both must be above 0")
    if seed < 0:
        raise BadLimits(f"seed: {seed}; it must be 0 or more")
    if iterations is not None:
        if iterations < 1:
            raise BadLimits(f"iterations: {iterations}; it must be 1 or more")
        seconds = np.inf
    tasks = [(goal, *start, iterations) for start in starts_of(setting, starts, seed, seconds)]
    starts = len(tasks)
    results: list[SearchResult] = []
    misses: list[str] = []

    def note(outcome: "SearchResult | str") -> None:
        if isinstance(outcome, str):
            misses.append(outcome)
        else:
            results.append(outcome)
            best = min(results, key=lambda result: result.value)
            progress(
                f"start {len(results) + len(misses)} of {starts}: {goal.words(outcome.value)}, "
                f"best {goal.reached(best.value):.4g}"
            )

    run_all(_run_start, tasks, seconds, note, _throttled(goal, progress))
    if not results:
        raise Infeasible(
            misses[0]
            if misses
            else "the search ended before any start kept to the limits. Try a longer search"
        )
    return min(results, key=lambda result: result.value)


def starts_of(setting: Setting, starts: int, seed: int, seconds: float) -> list[tuple[Setting, int]]:
    """Setting and seed of each start: as many as can converge in the time, and at least one per core.

    The first two starts have the first period, and the next ones take the other periods in turn. The first
    period is the longest and nearly always the best.
    """
    cores, periods = os.cpu_count() or 1, setting.periods
    count = min(starts, max(cores, int(min(seconds * cores / SETTLES, starts))))
    places = [max(place - 1, 0) % len(periods) for place in range(count)]
    return [(replace(setting, periods=(periods[k],)), seed + n) for n, k in enumerate(places)]


def _throttled(goal: Goal, progress: Callable[[str], None]) -> Callable[[float], None]:
    """A callback that passes on values that improve on all before, at most once per `PAUSE`."""
    best, last = np.inf, time.monotonic()

    def receive(value: float) -> None:
        nonlocal best, last
        best, better = min(best, value), value < best
        if better and time.monotonic() - last > PAUSE:
            last = time.monotonic()
            progress(f"searching: {goal.words(best)} so far")

    return receive


def _run_start(
    goal: Goal,
    setting: Setting,
    seed: int,
    iterations: int | None,
    seconds: float,
    stop: Stop,
    report: Report,
) -> "SearchResult | str":
    """Run one start, in this process or another."""
    budget = Budget(seconds, stop) if iterations is None else IterationBudget(iterations, stop)
    return one_start(goal, setting, seed, budget, report)


PER_HARMONIC = 20
"""Samples of the objective per period of the highest harmonic: inertial torque has up to four times its
frequency, and its square twice as much, so twenty samples represent the information matrix."""
EVERY = 2
"""Stride of the samples at which bounds are checked: between ten samples per period a series rises by at most
1 / cos(pi / 10), five percent, which is removed afterwards."""
SETTLED = 2
"""Number of further searches with limits tightened by the excess between samples; one leaves a tenth."""
FIRST = 0.5
"""Share of the budget after which the first of these begins."""
TRIES = 3
"""Number of random coefficients that a start tries: final values of two differ by a fifth."""
TRY_STEPS = 12
"""Steps of a try with the smoothest objective: enough to tell which of two ends a tenth better."""
APART = 1_000_000
"""Difference between the seeds of two tries, above the number of starts."""
TRYING = 0.2
"""Share of the budget within which tries must be expected to end, as the search restarts after them."""


def one_start(
    goal: Goal, setting: Setting, seed: int, budget: Budget, report: Callable[[float], None] = lambda _: None
) -> "SearchResult | str":
    """Search from the best of a few random starts; returns a sentence if nothing fits inside the limits.

    `report` is called with the value of each improved deliverable result.
    """
    problem = problem_of(goal, setting, setting.periods[seed % len(setting.periods)])
    delivery = Delivery(goal, setting, problem.basis, budget, report)
    try:
        start, curvature = best_of_tries(goal, setting, problem, seed, budget)
    except Infeasible as reason:  # no pose keeps all clearances
        return str(reason)
    note = delivery.offer_callback(problem)
    search = solve(problem, problem.unknowns(start), budget, FIRST * budget.amount, note, curvature=curvature)
    delivery.offer(start if search.unknowns is None else problem.coefficients(search.unknowns))
    if search.unknowns is not None:
        _settle(problem, search, delivery, setting, budget)
    return delivery.best(seed)


def _settle(problem: Problem, search: Search, delivery: Delivery, setting: Setting, budget: Budget) -> None:
    """Continue within limits tightened by the excess between samples, in the remaining budget."""
    assert search.unknowns is not None
    (goal, narrower), limits = delivery.narrowed(), setting.limits
    best = problem.coefficients(search.unknowns)
    for iteration in range(SETTLED):
        until = budget.amount - delivery.takes
        violations = [
            violation
            for fourier in problem.basis.fourier(best)
            for violation in violations_of(fourier, goal, setting.limits, setting.tick)
        ]
        worthwhile = violations or (narrower and iteration == 0)
        if budget.used >= until or budget.stop() or not worthwhile:
            return
        limits = tightened(limits, violations)
        tighter = problem_of(goal, replace(setting, limits=limits), problem.basis.period).last()
        tighter = replace(tighter, scale=problem.scale)  # the curvature was learned in these units
        note = delivery.offer_callback(tighter)
        search = solve(tighter, tighter.unknowns(best), budget, until, note, curvature=search.curvature)
        if search.unknowns is not None:
            best = tighter.coefficients(search.unknowns)
            delivery.offer(best)


def best_of_tries(
    goal: Goal, setting: Setting, problem: Problem, seed: int, budget: Budget
) -> tuple[np.ndarray, np.ndarray | None]:
    """Coefficients of the most promising of `TRIES` random starts after a few steps, shape (k, n).

    The second value is the curvature that it has learned, or None.
    """
    smooth, until = replace(problem, objectives=problem.objectives[:1]), TRYING * budget.amount
    first = best = random_start(goal, setting, problem.basis, seed)
    least, takes, curvature = np.inf, 0.0, None
    for number in range(TRIES):
        begun = budget.used
        if until - begun <= takes or budget.stop():
            break
        start = random_start(goal, setting, problem.basis, seed + APART * number) if number else first
        search = solve(smooth, smooth.unknowns(start), budget, until, most=TRY_STEPS)
        takes = max(takes, budget.used - begun)
        if search.unknowns is not None and search.value < least:
            best, least, curvature = problem.coefficients(search.unknowns), search.value, search.curvature
    return best, curvature


def problem_of(goal: Goal, setting: Setting, period: float) -> Problem:
    """The problem of a goal under all bounds, over Fourier series of one period."""
    basis = Basis(period, setting.harmonics, PER_HARMONIC * setting.harmonics, setting.series)
    limits = setting.limits
    bounds = kinematic_bounds(limits, 2 * np.pi * setting.harmonics / period)
    if np.any(np.isfinite(limits.torque)):
        nominal = design_model(goal.model, limits, period / basis.samples)
        bounds.append(TorqueBound(nominal, limits.torque, goal.payloads, goal.spread))
    bounds += [ClearanceBound(clearance) for clearance in setting.clearances]
    objectives = goal.objectives(limits, period / basis.samples)
    return Problem(basis, objectives, bounds, EVERY, largest_coefficients(basis, limits))


def largest_coefficients(basis: Basis, limits: Limits) -> np.ndarray:
    """Largest value of each coefficient alone within the kinematic limits, shape (k, n) [rad].

    In these units, a search takes steps of similar size along all coefficients.
    """
    room = 0.5 * (limits.position_upper - limits.position_lower)
    rate = 2 * np.pi / basis.period * np.arange(1, basis.harmonics + 1)[:, None]
    least = np.tile(room, (basis.harmonics, 1))
    for order, (lower, upper) in enumerate(list(ranges(limits).values())[1:], start=1):
        least = np.minimum(least, np.minimum(-lower, upper) / rate**order)
    return np.tile(np.concatenate([room[None], least, least]), (basis.series, 1))


def random_start(goal: Goal, setting: Setting, basis: Basis, seed: int) -> np.ndarray:
    """Random coefficients whose series keep to 90 % of the kinematic limits, shape (k, n)."""
    random, limits = np.random.default_rng(seed), setting.limits
    robot = replace(goal.model.robot, limits=limits)
    middle = 0.5 * (limits.position_lower + limits.position_upper)
    series = []
    for number in range(setting.series):
        center = (
            clear_position(robot, setting.clearances, seed + 1000 * number) if setting.clearances else middle
        )
        fade = np.arange(1, setting.harmonics + 1)
        sine, cosine = random.normal(size=(2, len(middle), setting.harmonics)) / fade
        series.append(inside_kinematics(Fourier(basis.period, center, sine, cosine), limits, 0.9))
    return basis.coefficients(series)
