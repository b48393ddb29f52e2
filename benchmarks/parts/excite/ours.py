"""Our own search on the arm, basis, limits and clock that every other tool is given."""

import contextlib

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.trajectories.errors import Infeasible
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.search.excite import SETTLES
from exidyn.trajectories.search.experiment import Experiment
from exidyn.trajectories.search.goals import Identify
from exidyn.trajectories.search.setting import Setting
from exidyn.trajectories.search.shrink import shrink_inside
from exidyn.trajectories.search.solve import Search, solve
from exidyn.trajectories.search.start import TRYING, best_of_tries, problem_of

from .arm import RATE, Arm, States
from .peers import CLOCK, DURATION, Best, PeerResult

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
        drawn, curvature = best_of_tries(
            goal, setting, problem, 1000 * seed + starts, min(TRYING * left, SETTLES), lambda: False
        )
        steps: list[tuple[float, np.ndarray]] = []

        def note(search: Search, steps: list[tuple[float, np.ndarray]] = steps) -> None:
            if search.unknowns is not None:
                steps.append((CLOCK() - begun, search.unknowns))

        solve(
            problem,
            problem.unknowns(drawn),
            stop=lambda: CLOCK() - begun > budget_seconds,
            report=note,
            curvature=curvature,
        )
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
