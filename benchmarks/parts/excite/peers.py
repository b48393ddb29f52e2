"""Searches of an exciting trajectory: random search, plain SLSQP, ours; same limits, criterion, clock.

All search Fourier series, as long as FIGAROH's trajectory, the first two with few harmonics as well as with
many. Every candidate that counts is judged afterwards, densely, off the clock.
"""

import contextlib
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import minimize

from exidyn.identification.arm.robot import Limits
from exidyn.trajectories.errors import Infeasible
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.search.delivery import Setting, shrink_inside
from exidyn.trajectories.search.excite import SETTLES, TRYING, best_of_tries, problem_of
from exidyn.trajectories.search.experiment import Experiment
from exidyn.trajectories.search.goals import Identify
from exidyn.trajectories.search.solve import Budget, Search, solve

from .arm import ALLOWED, RATE, Arm, States, Verdict

DURATION = 12.0
"""Length of every trajectory: six moves of two seconds in FIGAROH's UR10 example [s]."""
HARMONICS = (5, 12)
"""Few, with which differences are quick, and as many as exidyn takes."""
SEARCH_RATE = 20.0
"""Samples a second while searching, as in FIGAROH's UR10 example [Hz]."""
CONSTRAINT_SAMPLES = 24
"""Of the limits that SLSQP sees, a period of the highest harmonic: a peak between is at most 0.9 % higher."""
CLOCK = time.process_time
"""Clock of all tools: CPU time of their process."""


@dataclass(frozen=True, eq=False)
class PeerResult:
    """What a tool reached."""

    name: str  # Which tool
    condition: float  # Of the best trajectory that keeps to the limits; infinite where there is none
    seconds: float  # CPU time it took [s]
    history: list[tuple[float, float]]  # Seconds and condition number of each better trajectory
    note: str  # What it did and what its best trajectory violates


@dataclass
class Best:
    """Judges candidates in the order in which they were found, and keeps the best feasible one."""

    arm: Arm
    history: list[tuple[float, float]] = field(default_factory=list)
    verdict: Verdict | None = None
    infeasible: int = 0

    def offer(self, seconds: float, states: States) -> None:
        """Judge a candidate found after so many seconds."""
        verdict = self.arm.judge(states)
        if verdict.excess > ALLOWED:
            self.infeasible += 1
        elif self.verdict is None or verdict.condition < self.verdict.condition:
            self.verdict = verdict
            self.history.append((seconds, verdict.condition))

    def result(self, name: str, seconds: float, notes: Iterable[str]) -> PeerResult:
        """The result, with what the best trajectory violates among its notes."""
        parts = [*notes]
        if self.infeasible:
            parts.append(f"{self.infeasible} candidates outside the limits")
        if not self.verdict:
            parts.append("nothing feasible found")
        elif self.verdict.excess > 1e-6:  # rounding
            parts.append(f"its best: {100 * self.verdict.excess:.2g} % over the {self.verdict.where}")
        condition = self.verdict.condition if self.verdict else np.inf
        return PeerResult(name, condition, seconds, self.history, "; ".join(parts))


class Series:
    """Position = centre + sum over harmonics k of sine_k sin(k w t) + cosine_k cos(k w t), on a grid.

    Coefficients are one vector: for each of 1 + 2 harmonics functions, n values, one a joint.
    """

    def __init__(self, joints: int, harmonics: int, rate: float) -> None:
        time_axis = np.arange(round(DURATION * rate)) / rate
        w = 2 * np.pi / DURATION * np.arange(1, harmonics + 1)
        sine, cosine = np.sin(np.outer(time_axis, w)), np.cos(np.outer(time_axis, w))
        one = np.ones((len(time_axis), 1))
        self.joints, self.harmonics = joints, harmonics
        self._position = np.hstack([one, sine, cosine])
        self._velocity = np.hstack([0 * one, w * cosine, -w * sine])
        self._acceleration = np.hstack([0 * one, -(w**2) * sine, -(w**2) * cosine])

    def at(self, coefficients: np.ndarray) -> States:
        """Sampled motion of the coefficients, shape ((1 + 2 harmonics) n,) [rad]."""
        table = coefficients.reshape(-1, self.joints)
        return States(self._position @ table, self._velocity @ table, self._acceleration @ table)


def random_search(
    arm: Arm,
    budget_seconds: float,
    seed: int,
    harmonics: int,
) -> PeerResult:
    """Best of as many random series, scaled into the limits, as the budget allows."""
    random, grid = np.random.default_rng(seed), Series(arm.dof, harmonics, SEARCH_RATE)
    found, best, tried, start = [], np.inf, 0, CLOCK()
    while CLOCK() - start < budget_seconds:
        tried += 1
        coefficients = random_coefficients(arm, grid, random)
        if coefficients is None:
            continue
        states = grid.at(coefficients)
        condition = arm.condition(*states)
        if condition < best:
            best = condition
            found.append((CLOCK() - start, coefficients))
    return _judged("random search", arm, found, CLOCK() - start, [f"{tried} tried"], grid)


def random_coefficients(arm: Arm, grid: Series, random: np.random.Generator) -> np.ndarray | None:
    """A random series scaled to the largest amplitude that the limits allow; none if torque forbids it."""
    limits, n = arm.limits, arm.dof
    wave = random.normal(size=(2, grid.harmonics, n)) / np.arange(1, grid.harmonics + 1)[:, None]
    table = np.concatenate([np.zeros((1, n)), wave.reshape(-1, n)])
    trial = grid.at(table.ravel())
    half = 0.5 * (limits.position_upper - limits.position_lower)
    reach = np.max(np.abs(trial.position), axis=0)
    # 1 % is kept for what the grid does not see between its samples.
    scale = 0.99 * np.minimum(limits.velocity / np.max(np.abs(trial.velocity), axis=0), half / reach)
    room = half - scale * reach
    table *= scale
    table[0] = 0.5 * (limits.position_lower + limits.position_upper) + random.uniform(-room, room)
    for _ in range(5):
        if np.all(np.abs(arm.torque(grid.at(table.ravel()))) <= 0.99 * limits.torque):
            return table.ravel()
        table[1:] *= 0.8
    return None


class _Expired(Exception):
    """The budget is used up."""


def slsqp(
    arm: Arm,
    budget_seconds: float,
    seed: int,
    harmonics: int,
) -> PeerResult:
    """SciPy's SLSQP with two-point differences on the condition number, from random starts.

    Position, velocity and torque limits are sampled inequality constraints.
    """
    random, grid = np.random.default_rng(seed), Series(arm.dof, harmonics, SEARCH_RATE)
    found: list[tuple[float, np.ndarray]] = []
    start = CLOCK()

    def in_time(function: Callable[[np.ndarray], Any], coefficients: np.ndarray) -> Any:
        if CLOCK() - start > budget_seconds:
            raise _Expired
        return function(coefficients)

    def condition(coefficients: np.ndarray) -> float:
        return arm.condition(*grid.at(coefficients))

    def keep(coefficients: np.ndarray) -> None:
        found.append((CLOCK() - start, coefficients.copy()))

    limits, starts, finished = _Limits(arm, harmonics), 0, 0
    try:
        while CLOCK() - start < budget_seconds:
            guess = random_coefficients(arm, grid, random)
            if guess is None:
                continue
            starts += 1
            keep(guess)
            minimize(
                partial(in_time, condition),
                guess,
                method="SLSQP",
                callback=keep,
                constraints={"type": "ineq", "fun": partial(in_time, limits)},
                options={"maxiter": 200, "ftol": 1e-3},
            )
            finished += 1
    except _Expired:
        pass
    notes = [f"{starts} starts, {finished} of them ended, {len(found) - starts} iterations"]
    return _judged("finite-difference SLSQP", arm, found, CLOCK() - start, notes, grid)


class _Limits:
    """How far position, velocity and torque are inside their limits, as shares of them, at samples."""

    def __init__(self, arm: Arm, harmonics: int) -> None:
        rate = CONSTRAINT_SAMPLES * harmonics / DURATION
        self.arm, self.grid = arm, Series(arm.dof, harmonics, rate)
        limits = arm.limits
        self.middle = 0.5 * (limits.position_lower + limits.position_upper)
        self.half = 0.5 * (limits.position_upper - limits.position_lower)

    def __call__(self, coefficients: np.ndarray) -> np.ndarray:
        states, limits = self.grid.at(coefficients), self.arm.limits
        shares = [
            (states.position - self.middle) / self.half,
            states.velocity / limits.velocity,
            self.arm.torque(states) / limits.torque,
        ]
        return np.concatenate([side.ravel() for share in shares for side in (1 - share, 1 + share)])


def _judged(
    name: str,
    arm: Arm,
    found: list[tuple[float, np.ndarray]],
    seconds: float,
    notes: list[str],
    grid: Series,
) -> PeerResult:
    best, dense = Best(arm), Series(arm.dof, grid.harmonics, RATE)
    for when, coefficients in found:
        best.offer(when, dense.at(coefficients))
    return best.result(name, seconds, notes)


FAR = 1e4
"""Acceleration and jerk limits that bind nowhere [rad/s^2, rad/s^3]: the other tools know none."""


def setting_of(arm: Arm, harmonics: int) -> tuple[Identify, Setting]:
    """Goal and setting for the arm, without limits of acceleration and jerk."""
    n, given = arm.dof, arm.limits
    far = np.full(n, FAR)
    limits = Limits(given.position_lower, given.position_upper, given.velocity, far, far * FAR, given.torque)
    setting = Setting(limits, harmonics, (DURATION,), [], tick=1.0 / RATE)
    return Identify(Experiment.of(arm.model)), setting


def ours(
    arm: Arm,
    budget_seconds: float,
    seed: int,
    harmonics: int,
) -> PeerResult:
    """One start after another while the budget lasts, in one process; the best after the exact check."""
    goal, setting = setting_of(arm, harmonics)
    best, begun, starts, found = Best(arm), CLOCK(), 0, []
    while CLOCK() - begun < budget_seconds:
        problem, left = problem_of(goal, setting, DURATION), budget_seconds - (CLOCK() - begun)
        budget = Budget(min(left, SETTLES / TRYING))
        drawn, curvature = best_of_tries(goal, setting, problem, 1000 * seed + starts, budget)
        steps: list[tuple[float, np.ndarray]] = []

        def note(search: Search, steps: list[tuple[float, np.ndarray]] = steps) -> None:
            if search.unknowns is not None:
                steps.append((CLOCK() - begun, search.unknowns))

        until_end = Budget(stop=lambda: CLOCK() - begun > budget_seconds)
        solve(problem, problem.unknowns(drawn), until_end, report=note, curvature=curvature)
        found += [(when, problem.basis.fourier(problem.coefficients(at))[0]) for when, at in steps]
        starts += 1
    seconds = CLOCK() - begun
    for when, series in found:
        if best.verdict and arm.condition(*sampled(series)) >= best.verdict.condition:
            continue
        with contextlib.suppress(Infeasible):
            kept = shrink_inside(series, goal, setting.limits, setting.clearances, setting.tick)
            best.offer(when, sampled(kept))
    return best.result("exidyn", seconds, [f"{starts} starts"])


def sampled(series: Fourier) -> States:
    """One period as the judge wants it."""
    states = series.at(np.arange(round(DURATION * RATE)) / RATE)
    return States(states.position, states.velocity, states.acceleration)
