"""Start: from random coefficients to series inside all limits, with the value that is delivered."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from exidyn.identify.arm.motion import Motion
from exidyn.identify.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..clearances.configurations import clear_position
from ..errors import Infeasible
from ..families.fourier import Fourier
from ..limits.check import Violation
from ..limits.usable_limits import ranges
from .bounds import ClearanceBound, kinematic_bounds
from .drawn_arms import share_beyond, with_own_factor
from .goals import Goal
from .problem import Basis, Problem
from .shrink import inside_kinematics, shrink_inside, tightened, violations_of
from .solve import Search, solve
from .torque_bound import TorqueBound
from .torque_spread import TorqueSpread
from .unknowns import design_model

PER_HARMONIC = 20
"""Samples of the objective a period of the highest harmonic: inertial torque has up to four times its
frequency, and its square twice that again, so twenty hold the information matrix."""
EVERY = 2
"""Of these, one in so many is kept to the bounds: between ten samples a period a series rises by at most
1 / cos(pi / 10), five per cent, which is taken back afterwards."""
FINE = 0.01
"""Spacing at which the value of the result is taken [s]: friction reverses over it as in a measured row."""
SETTLED = 2
"""Searches within limits tightened by what a series passed between samples: one leaves a tenth of it."""
FIRST = 0.6
"""Share of the time after which the first of these begins, whatever the search has come to."""
TRIES = 3
"""Random coefficients that a start tries: where two of them end differs by a fifth."""
TRY_STEPS = 15
"""Steps of a try, by the smoothest objective: after them it shows which of two ends a tenth better."""
APART = 1_000_000
"""Between the seeds of two tries: more than there are starts."""
TRYING = 0.25
"""Share of the time after which no other is tried."""
WIDER = 1.15
"""Factor on a band that lets too many arms beyond a torque limit, until it is wide enough."""
NARROWEST = 0.25
"""Share of the widest band that the first such step comes to at least: a band may have been nothing."""
ASIDE = 0.1
"""Share of the time of a search that goes into what would be delivered if it ended now."""
OFFER = 0.3
"""What it takes to bring a series inside all limits, until the first has shown it [s]."""


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
        history: Seconds and value of the goal as it would have been delivered, as the search went on.
        spread: What is not known of the torque, with the factor by which the series keep to the limits.
    """

    series: tuple[Fourier, ...]
    value: float
    seed: int
    history: list[tuple[float, float]] = field(default_factory=list)
    spread: TorqueSpread | None = None


def one_start(
    goal: Goal,
    setting: Setting,
    seed: int,
    seconds: float,
    stop: Callable[[], bool],
    report: Callable[[float], None] = lambda _: None,
) -> "Found | str":
    """Search from one random start; a sentence where it could not be brought inside the limits.

    `report` is called with the value of what would be delivered, whenever that is better.
    """
    problem = problem_of(goal, setting, setting.periods[seed % len(setting.periods)])
    delivery = Delivery(goal, setting, problem.basis, report)
    try:
        start = best_of_tries(goal, setting, problem, seed, TRYING * seconds, stop)
        coarse = FIRST * seconds - delivery.seconds
        search = solve(problem, problem.unknowns(start), coarse, stop, delivery.now_and_then(problem))
        best = start if search.unknowns is None else problem.coefficients(search.unknowns)
        delivery.offer(best)
        limits, narrower = setting.limits, False
        if search.unknowns is not None:
            goal, narrower = delivery.narrowed()
        for again in range(SETTLED if search.unknowns is not None else 0):
            left = seconds - delivery.seconds - delivery.takes
            beyond = _violations(problem.basis.fourier(best), goal, setting)
            if left <= 0.0 or stop() or not (beyond or (narrower and again == 0)):
                break
            limits = tightened(limits, beyond)
            within = problem_of(goal, replace(setting, limits=limits), problem.basis.period)
            within = replace(within, objectives=within.objectives[-1:])
            search = solve(within, within.unknowns(best), left, stop, delivery.now_and_then(within))
            if search.unknowns is not None:
                best = within.coefficients(search.unknowns)
                delivery.offer(best)
        return delivery.best(seed)
    except Infeasible as reason:
        return str(reason)


def best_of_tries(
    goal: Goal, setting: Setting, problem: Problem, seed: int, seconds: float, stop: Callable[[], bool]
) -> np.ndarray:
    """Where the most promising of `TRIES` random starts has come to in a few steps, shape (k, n)."""
    smooth, begun = replace(problem, objectives=problem.objectives[:1]), time.monotonic()
    first = best = random_start(goal, setting, problem.basis, seed)
    least = np.inf
    for number in range(TRIES):
        left = seconds - (time.monotonic() - begun)
        if left <= 0.0 or stop():
            break
        start = random_start(goal, setting, problem.basis, seed + APART * number) if number else first
        found = solve(smooth, smooth.unknowns(start), left, stop, most=TRY_STEPS)
        if found.unknowns is not None and found.value < least:
            best, least = problem.coefficients(found.unknowns), found.value
    return best


class Delivery:
    """The best of the series that a search came by, each brought inside all limits.

    Args:
        goal: What they are for.
        setting: Within what.
        basis: What coefficients mean.
        report: Called with each value that is better than all before.

    Attributes:
        takes: Time of the last `offer` [s].
    """

    def __init__(self, goal: Goal, setting: Setting, basis: Basis, report: Callable[[float], None]) -> None:
        self._goal, self._setting, self._basis, self._report = goal, setting, basis, report
        self._begun, self._aside = time.monotonic(), 0.0
        self.takes = OFFER
        self._best: Found | None = None
        self._history: list[tuple[float, float]] = []
        self._objective = goal.objectives(setting.limits, FINE)[-1]

    @property
    def seconds(self) -> float:
        """Time since the search began [s]."""
        return time.monotonic() - self._begun

    def offer(self, coefficients: np.ndarray) -> None:
        """Bring series inside all limits, and keep them if they are the best.

        Raises:
            Infeasible: They do not fit, nor did any before.
        """
        begun = self.seconds
        try:
            kept, spread = self._kept(coefficients)
        except Infeasible:
            if self._best is None:
                raise
            return
        finally:
            self.takes = self.seconds - begun
            self._aside += self.takes
        value = self._objective.value(_joined(kept))
        if self._best is None or value < self._best.value:
            self._best = Found(kept, value, 0, spread=spread)
            self._history.append((self.seconds, value))
            self._report(value)

    def _kept(self, coefficients: np.ndarray) -> tuple[tuple[Fourier, ...], TorqueSpread | None]:
        """Inside all limits, those of torque for enough of the drawn arms: else with a wider band.

        Raises:
            Infeasible: They do not fit.
        """
        within, goal = self._setting, self._goal
        while True:
            kept = tuple(
                shrink_inside(one, goal, within.limits, within.clearances, within.tick)
                for one in self._basis.fourier(coefficients)
            )
            spread = goal.spread
            if spread is None or spread.factor >= spread.widest:
                return kept, spread
            if all(
                share_beyond(goal, one.every(FINE), within.limits.torque) <= 1.0 - spread.share
                for one in kept
            ):
                return kept, spread
            wider = max(WIDER * spread.factor, NARROWEST * spread.widest)
            goal = goal.with_spread(replace(spread, factor=min(wider, spread.widest)))

    def narrowed(self) -> tuple[Goal, bool]:
        """The goal with a band as the best motion needs it, from now on; and whether it is narrower."""
        before = self._goal.spread
        if before is None or self._best is None:
            return self._goal, False
        states = self._best.series[0].every(FINE)
        self._goal = with_own_factor(self._goal, states, self._setting.limits.torque)
        assert self._goal.spread is not None
        return self._goal, self._goal.spread.factor < before.factor

    def now_and_then(self, problem: Problem) -> Callable[[Search], None]:
        """What a search calls whenever it is better; most of its time must remain its own."""

        def receive(search: Search) -> None:
            if search.unknowns is not None and self._aside + self.takes <= ASIDE * self.seconds:
                try:
                    self.offer(problem.coefficients(search.unknowns))
                except Infeasible:  # as yet
                    return

        return receive

    def best(self, seed: int) -> Found:
        """The best of all; `offer` raised if there is none."""
        assert self._best is not None
        return replace(self._best, seed=seed, history=self._history)


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


def _joined(series: Sequence[Fourier]) -> Motion:
    """Motions of all series at samples `FINE` apart, one after the other, as one."""
    moments = np.arange(0.0, series[0].period, FINE)
    motions = [one.at(moments).motion() for one in series]
    states = [(motion.position, motion.velocity, motion.acceleration) for motion in motions]
    position, velocity, acceleration = (np.concatenate(parts) for parts in zip(*states, strict=True))
    return Motion.of(np.arange(len(position)) * FINE, position, velocity, acceleration)
