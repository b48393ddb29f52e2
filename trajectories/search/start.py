"""Start: from random coefficients to series inside all limits, with the value that is delivered."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..clearances.configurations import clear_position
from ..errors import Infeasible
from ..families.fourier import Fourier
from ..limits.check import Violation
from ..limits.usable_limits import ranges
from .bounds import ClearanceBound, kinematic_bounds
from .delivery import Delivery
from .goals import Goal
from .problem import Basis, Problem
from .setting import Found, Setting
from .shrink import inside_kinematics, tightened, violations_of
from .solve import Search, solve
from .torque_bound import TorqueBound
from .unknowns import design_model

PER_HARMONIC = 20
"""Samples of the objective a period of the highest harmonic: inertial torque has up to four times its
frequency, and its square twice that again, so twenty hold the information matrix."""
EVERY = 2
"""Of these, one in so many is kept to the bounds: between ten samples a period a series rises by at most
1 / cos(pi / 10), five per cent, which is taken back afterwards."""
SETTLED = 2
"""Searches within limits tightened by what a series passed between samples: one leaves a tenth of it."""
FIRST = 0.5
"""Share of the time after which the first of these begins, whatever the search has come to."""
TRIES = 3
"""Random coefficients that a start tries: where two of them end differs by a fifth."""
TRY_STEPS = 12
"""Steps of a try, by the smoothest objective: after them it shows which of two ends a tenth better."""
APART = 1_000_000
"""Between the seeds of two tries: more than there are starts."""
TRYING = 0.2
"""Share of the time within which a try must be expected to end: the search itself begins anew after it."""


def one_start(
    goal: Goal,
    setting: Setting,
    seed: int,
    seconds: float,
    stop: Callable[[], bool],
    report: Callable[[float], None] = lambda _: None,
) -> "Found | str":
    """Search from the best of a few random starts; a sentence where nothing fits inside the limits.

    `report` is called with the value of what would be delivered, whenever that is better.
    """
    problem = problem_of(goal, setting, setting.periods[seed % len(setting.periods)])
    delivery = Delivery(goal, setting, problem.basis, report)
    try:
        start, curvature = best_of_tries(goal, setting, problem, seed, TRYING * seconds, stop)
    except Infeasible as reason:  # no pose is clear of everything
        return str(reason)
    coarse, note = FIRST * seconds - delivery.seconds, delivery.now_and_then(problem)
    search = solve(problem, problem.unknowns(start), coarse, stop, note, curvature=curvature)
    delivery.offer(start if search.unknowns is None else problem.coefficients(search.unknowns))
    if search.unknowns is not None:
        _settle(problem, search, delivery, setting, seconds, stop)
    return delivery.best(seed)


def _settle(
    problem: Problem,
    search: Search,
    delivery: Delivery,
    setting: Setting,
    seconds: float,
    stop: Callable[[], bool],
) -> None:
    """Search on within limits tightened by what a series passed between samples, in the time that is left."""
    assert search.unknowns is not None
    (goal, narrower), limits = delivery.narrowed(), setting.limits
    best = problem.coefficients(search.unknowns)
    for again in range(SETTLED):
        left = seconds - delivery.seconds - delivery.takes
        beyond = _violations(problem.basis.fourier(best), goal, setting)
        if left <= 0.0 or stop() or not (beyond or (narrower and again == 0)):
            return
        limits = tightened(limits, beyond)
        within = problem_of(goal, replace(setting, limits=limits), problem.basis.period).last()
        within = replace(within, scale=problem.scale)  # in whose units the curvature was learnt
        note, learnt = delivery.now_and_then(within), search.curvature
        search = solve(within, within.unknowns(best), left, stop, note, curvature=learnt)
        if search.unknowns is not None:
            best = within.coefficients(search.unknowns)
            delivery.offer(best)


def best_of_tries(
    goal: Goal, setting: Setting, problem: Problem, seed: int, seconds: float, stop: Callable[[], bool]
) -> tuple[np.ndarray, np.ndarray | None]:
    """Where the most promising of `TRIES` random starts has come to in a few steps, shape (k, n).

    With it goes the curvature that it has learnt, None for nothing.
    """
    smooth, begun = replace(problem, objectives=problem.objectives[:1]), time.monotonic()
    first = best = random_start(goal, setting, problem.basis, seed)
    least, takes, curvature = np.inf, 0.0, None
    for number in range(TRIES):
        left = seconds - (time.monotonic() - begun)
        if left <= takes or stop():
            break
        start = random_start(goal, setting, problem.basis, seed + APART * number) if number else first
        found = solve(smooth, smooth.unknowns(start), left, stop, most=TRY_STEPS)
        takes = max(takes, left - (seconds - (time.monotonic() - begun)))
        if found.unknowns is not None and found.value < least:
            best, least, curvature = problem.coefficients(found.unknowns), found.value, found.curvature
    return best, curvature


def _violations(series: Sequence[Fourier], goal: Goal, setting: Setting) -> list[Violation]:
    return [v for one in series for v in violations_of(one, goal, setting.limits, setting.tick)]


def problem_of(goal: Goal, setting: Setting, period: float) -> Problem:
    """The goal under all bounds, over Fourier series of one period."""
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
    """How large each coefficient alone may be within the kinematic limits, shape (k, n) [rad].

    In these units a search takes steps of like size along all of them.
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
        centre = (
            clear_position(robot, setting.clearances, seed + 1000 * number) if setting.clearances else middle
        )
        fade = np.arange(1, setting.harmonics + 1)
        sine, cosine = random.normal(size=(2, len(middle), setting.harmonics)) / fade
        series.append(inside_kinematics(Fourier(basis.period, centre, sine, cosine), limits, 0.9))
    return basis.coefficients(series)
