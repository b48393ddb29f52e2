"""Our own search on the arm, basis, limits and clock that every other tool is given."""

import contextlib
import time
from collections.abc import Callable

import numpy as np
from common import show

from exidyn.identification.arm.robot import Limits
from exidyn.identification.robot_files.geometry import read_geometry
from exidyn.trajectories.clearances.collision import Collision
from exidyn.trajectories.errors import Infeasible
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.search.excite import SETTLES
from exidyn.trajectories.search.experiment import Experiment
from exidyn.trajectories.search.goals import Identify
from exidyn.trajectories.search.setting import Setting
from exidyn.trajectories.search.shrink import shrink_inside
from exidyn.trajectories.search.solve import Search, solve
from exidyn.trajectories.search.start import TRYING, best_of_tries, problem_of, random_start

from .arm import RATE, Arm, States
from .peers import DURATION, Best, Clock, PeerResult

FAR = 1e4
"""Acceleration and jerk limits that bind nowhere [rad/s^2, rad/s^3]: the other tools know none."""


def setting_of(arm: Arm, collisions: bool, harmonics: int = Wishes().harmonics) -> tuple[Identify, Setting]:
    """Goal and setting for the arm, without limits of acceleration and jerk."""
    n, given = arm.dof, arm.limits
    far = np.full(n, FAR)
    limits = Limits(given.position_lower, given.position_upper, given.velocity, far, far * FAR, given.torque)
    clearances = []
    if collisions:
        geometry = read_geometry(arm.urdf, [arm.packages])
        if geometry is not None:
            clearances.append(Collision.of(arm.model.robot, geometry))
    setting = Setting(limits, harmonics, (DURATION,), clearances, tick=1.0 / RATE)
    return Identify(Experiment.of(arm.model)), setting


def ours(
    arm: Arm,
    budget_seconds: float,
    seed: int,
    harmonics: int = Wishes().harmonics,
    *,
    collisions: bool = False,
    clock: Clock = time.perf_counter,
) -> PeerResult:
    """One start after another while the budget lasts, in one process; the best after the exact check."""
    goal, setting = setting_of(arm, collisions, harmonics)
    best, begun, starts, found = Best(arm, collisions), clock(), 0, []
    while clock() - begun < budget_seconds:
        problem, left = problem_of(goal, setting, DURATION), budget_seconds - (clock() - begun)
        drawn, curvature = best_of_tries(
            goal, setting, problem, 1000 * seed + starts, min(TRYING * left, SETTLES), lambda: False
        )
        steps: list[tuple[float, np.ndarray]] = []

        def note(search: Search, steps: list[tuple[float, np.ndarray]] = steps) -> None:
            if search.unknowns is not None:
                steps.append((clock() - begun, search.unknowns))

        solve(
            problem,
            problem.unknowns(drawn),
            stop=lambda: clock() - begun > budget_seconds,
            report=note,
            curvature=curvature,
        )
        found += [(when, problem.basis.fourier(problem.coefficients(at))[0]) for when, at in steps]
        starts += 1
    seconds = clock() - begun
    for when, series in found:
        if best.verdict and arm.condition(*sampled(series)) >= best.verdict.condition:
            continue  # to be shrunk takes seconds where there are bodies to be clear of
        with contextlib.suppress(Infeasible):  # of the first iterates some collide even when they are shrunk
            kept = shrink_inside(series, goal, setting.limits, setting.clearances, setting.tick)
            best.offer(when, sampled(kept))
    return best.result("exidyn", seconds, [f"{starts} starts"])


def sampled(series: Fourier) -> States:
    """One period as the judge wants it."""
    states = series.at(np.arange(round(DURATION * RATE)) / RATE)
    return States(states.position, states.velocity, states.acceleration)


def every_seed(arm: Arm, seeds: int, seconds: float) -> dict[str, float]:
    """How the condition number of one start, cut short, varies with its seed, and how often none is found."""
    reached = [ours(arm, seconds, 100 + seed, clock=time.process_time).condition for seed in range(seeds)]
    kept = np.array([condition for condition in reached if np.isfinite(condition)])
    row = [seeds, seeds - len(kept), kept.min(), np.median(kept), kept.max()]
    header = ["seeds", "failed", "best", "median", "worst"]
    show(f"Condition number by seed, {seconds:g} s each", header, [row])
    return {"seeds": seeds, "seeds_failed": seeds - len(kept), "condition_worst_seed": float(kept.max())}


def gradient(arm: Arm, repeats: int = 5) -> dict[str, float]:
    """Time of the exact gradient against two-point differences of the same criterion, and how they agree."""
    goal, setting = setting_of(arm, collisions=False)
    problem = problem_of(goal, setting, DURATION)
    at = problem.unknowns(random_start(goal, setting, problem.basis, 0))
    objective = problem.objectives[-1]

    def value(unknowns: np.ndarray) -> float:
        return objective.value(problem.basis.motion(problem.coefficients(unknowns)))

    exact = problem.value(at, objective)[1]()
    central = np.array([_central(value, at, k) for k in range(len(at))])
    exact_time = _fastest(lambda: problem.value(at, objective)[1](), repeats)
    steps = 1e-7 * np.eye(len(at))
    forward_time = _fastest(lambda: [value(at), *(value(at + step) for step in steps)], 2)
    error = float(np.max(np.abs(exact - central)) / np.max(np.abs(central)))
    rows = [["exact", 1e3 * exact_time, error], ["two-point differences", 1e3 * forward_time, None]]
    header = ["gradient", "ms", "worst error against central differences"]
    show(f"Criterion and gradient by {len(at)} coefficients", header, rows)
    return {"gradient_speedup": forward_time / exact_time, "gradient_error": error}


def _central(value: Callable[[np.ndarray], float], at: np.ndarray, k: int, step: float = 1e-5) -> float:
    shift = step * np.eye(len(at))[k]
    return (value(at + shift) - value(at - shift)) / (2 * step)


def _fastest(work: Callable[[], object], repeats: int) -> float:
    """Shortest CPU time of several [s]."""
    times = []
    for _ in range(repeats):
        begun = time.process_time()
        work()
        times.append(time.process_time() - begun)
    return min(times)
