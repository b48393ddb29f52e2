"""Excite: the Fourier series that serves a goal best within the limits."""

import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace

import numpy as np

from exidyn.identify.arm.motion import Motion
from exidyn.identify.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..clearances.configurations import clear_position
from ..errors import BadLimits, Infeasible
from ..families.fourier import Fourier
from ..limits.usable_limits import ranges
from .bounds import ClearanceBound, kinematic_bounds
from .goals import Goal
from .parallel import Stop, report, run_all
from .problem import Basis, Problem
from .shrink import inside_kinematics, shrink_inside
from .solve import Search, solve
from .torque_bound import TorqueBound
from .unknowns import design_model

PER_HARMONIC = 20
"""Samples of the objective a period of the highest harmonic: inertial torque has up to four times its
frequency, and its square twice that again, so twenty hold the information matrix."""
EVERY = 2
"""Of these, one in so many is kept to the bounds: between ten samples a period a series rises by at most
1 / cos(pi / 10), five per cent, which the exact check takes back."""
PAUSE = 5.0
"""Between two sentences about a search that runs [s]."""
FINE = 0.01
"""Spacing at which the value of the result is taken [s]: friction reverses over it as in a measured row."""


@dataclass(frozen=True, eq=False)
class Setting:
    """Within what to search.

    Attributes:
        limits: Finite ones of position, velocity, acceleration and jerk.
        harmonics: Number of harmonics.
        periods: Base periods that the starts take in turn [s].
        clearances: Collisions and regions.
        series: How many trajectories are planned together.
        tick: Tick of the controller [s]; a period is a whole number of them.
    """

    limits: Limits
    harmonics: int = 5
    periods: tuple[float, ...] = (10.0,)
    clearances: Sequence[Clearance] = ()
    series: int = 1
    tick: float = 0.002


@dataclass(frozen=True, eq=False)
class Found:
    """What one start came to, after the exact check.

    Attributes:
        series: The trajectories.
        value: Value of the goal, at samples `FINE` apart.
        seed: Seed of this start.
        history: Seconds and value of the goal, as the search went on.
    """

    series: tuple[Fourier, ...]
    value: float
    seed: int
    history: list[tuple[float, float]] = field(default_factory=list)


def excite(
    goal: Goal,
    setting: Setting,
    *,
    starts: int = 4,
    seed: int = 0,
    seconds: float = 60.0,
    executor: Executor | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Found:
    """The best of several starts.

    Args:
        goal: What the trajectory is for.
        setting: Limits, harmonics, period.
        starts: Random starts, with seeds `seed`, `seed` + 1 and so on.
        seed: Seed of the first start.
        seconds: Length of the search [s], not counting the start of its processes.
        executor: Where starts run; a pool of processes unless given.
        progress: Called with a sentence whenever a start ends, and now and then while they run.

    Raises:
        BadLimits: No start, or no time.
        Infeasible: No start could be brought inside the limits.
    """
    if starts < 1 or not seconds > 0.0:
        raise BadLimits(f"a search of {starts} starts in {seconds:g} s; both must be above 0")
    if seed < 0:
        raise BadLimits(f"seed: {seed}; it must be 0 or more")
    tasks = [(goal, setting, seed + k) for k in range(starts)]
    found: list[Found] = []
    misses: list[str] = []

    def note(outcome: "Found | str") -> None:
        if isinstance(outcome, str):
            misses.append(outcome)
        else:
            found.append(outcome)
            best = min(found, key=lambda one: one.value)
            progress(
                f"start {len(found) + len(misses)} of {starts}: {goal.words(outcome.value)}; "
                f"best {goal.words(best.value)}"
            )

    run_all(one_start, tasks, seconds, executor, note, _now_and_then(goal, progress))
    if not found:
        raise Infeasible(
            misses[0] if misses else "stopped before a start had kept to the limits; give it longer"
        )
    return min(found, key=lambda one: one.value)


def _now_and_then(goal: Goal, progress: Callable[[str], None]) -> Callable[[float], None]:
    """Passes on what a search reports if it is better than all before, but not more often than `PAUSE`."""
    best, last = np.inf, time.monotonic()

    def receive(value: float) -> None:
        nonlocal best, last
        best, better = min(best, value), value < best
        if better and time.monotonic() - last > PAUSE:
            last = time.monotonic()
            progress(f"searching: {goal.words(best)} so far, where the limits are sampled")

    return receive


def one_start(goal: Goal, setting: Setting, seed: int, seconds: float, stop: Stop) -> "Found | str":
    """Search from one random start; a sentence where it could not be brought inside the limits."""
    period = setting.periods[seed % len(setting.periods)]
    problem = problem_of(goal, setting, period)
    try:
        start = random_start(goal, setting, problem.basis, seed)
        search = solve(problem, problem.unknowns(start), seconds, stop, lambda s: report(s.value))
        unknowns = start if search.unknowns is None else problem.coefficients(search.unknowns)
        return finished(goal, setting, problem.basis.fourier(unknowns), seed, search)
    except Infeasible as reason:
        return str(reason)


def problem_of(goal: Goal, setting: Setting, period: float) -> Problem:
    """The goal under all bounds, over Fourier series of one period."""
    basis = Basis(period, setting.harmonics, PER_HARMONIC * setting.harmonics, setting.series)
    limits = setting.limits
    bounds = kinematic_bounds(limits, 2 * np.pi * setting.harmonics / period)
    if np.any(np.isfinite(limits.torque)):
        nominal = design_model(goal.model, limits, period / basis.samples)
        bounds.append(TorqueBound(nominal, limits.torque, goal.payloads))
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


def finished(goal: Goal, setting: Setting, series: list[Fourier], seed: int, search: Search) -> Found:
    """Series brought inside all limits between samples too, with their value."""
    kept = tuple(shrink_inside(one, goal, setting.limits, setting.clearances, setting.tick) for one in series)
    time = np.arange(0.0, kept[0].period, FINE)
    motions = [one.at(time).motion() for one in kept]
    value = goal.objectives(setting.limits, FINE)[-1].value(joined(motions))
    return Found(kept, value, seed, search.history)


def joined(motions: Sequence[Motion]) -> Motion:
    """Motions one after the other, as one."""
    states = [(motion.position, motion.velocity, motion.acceleration) for motion in motions]
    position, velocity, acceleration = (np.concatenate(parts) for parts in zip(*states, strict=True))
    return Motion.of(np.arange(len(position)) * FINE, position, velocity, acceleration)
