"""Shrink: bring a series inside the limits, between samples too."""

from collections.abc import Callable, Sequence
from dataclasses import fields, replace

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..errors import Infeasible
from ..families.fourier import Fourier
from ..limits.check import Violation, check
from ..limits.usable_limits import ranges
from .goals import Goal
from .torque_bound import TorqueBound

STEP = 0.99
"""Factor of the first step if no ratio gives the excess, and relative precision of the largest feasible
excursion. Each further step squares the factor."""
LEAST = 0.2
"""Share of the excursion at which the search ends as infeasible."""
MOST = 10
"""Maximum number of steps by ratios: each brings its joint inside, and more would not help."""


def inside_kinematics(series: Fourier, limits: Limits, share: float = 1.0) -> Fourier:
    """The series with each joint's excursion scaled to `share` of what its tightest limit allows."""
    room = []
    for (name, (lower, upper)), reached in zip(ranges(limits).items(), series.extremes(), strict=True):
        about = series.centre if name == "position" else 0.0
        room += [(upper - about) / (reached.upper - about), (lower - about) / (reached.lower - about)]
    return series.scaled(share * np.min(room, axis=0))


def violations_of(series: Fourier, goal: Goal, limits: Limits, tick: float) -> list[Violation]:
    """Violations of the limits by a series, between samples too, in every run of the goal."""
    bound = TorqueBound(goal.model, limits.torque, goal.payloads, goal.spread)
    return [v for payload in goal.payloads for v in check(series, limits, tick, bound.of(payload))]


def tightened(limits: Limits, violations: Sequence[Violation]) -> Limits:
    """Limits tightened by each excess: rates and torques by its share, positions by its amount."""
    changed = {f.name: np.array(getattr(limits, f.name)) for f in fields(limits)}
    for kind, joint, _, value, limit in violations:
        side = "lower" if value < limit else "upper"
        if kind in ("position", "stop"):
            changed[f"position_{side}"][joint] -= value - limit
        elif kind in ("velocity", "acceleration") and side == "lower":
            changed[f"{kind}_lower"][joint] *= limit / value
        elif kind in changed:
            changed[kind][joint] *= limit / value
    return replace(limits, **changed)


def shrink_inside(
    series: Fourier, goal: Goal, limits: Limits, clearances: Sequence[Clearance], tick: float
) -> Fourier:
    """The series, scaled down until it keeps every limit at all times.

    Raises:
        Infeasible: Not even a small motion about its center keeps to the limits.
    """

    def excess(candidate: Fourier) -> tuple[list[Violation], bool]:
        return violations_of(candidate, goal, limits, tick), all(
            clearance.worst(candidate).allowed for clearance in clearances
        )

    for _ in range(MOST):
        violations, clear = excess(series)
        shares = _shares(series, violations)
        if np.all(shares == 1.0):
            break
        series = series.scaled(shares)
    if not violations and clear:
        return series
    step, remaining = STEP, STEP
    while remaining >= LEAST:
        outside, series = series, series.scaled(np.full(series.dof, step))
        violations, clear = excess(series)
        if not violations and clear:
            return _largest(outside, step, excess)
        step **= 2
        remaining *= step
    raise Infeasible(_sentence(goal, violations, clearances, series))


def _largest(
    outside: Fourier, step: float, excess: Callable[[Fourier], tuple[list[Violation], bool]]
) -> Fourier:
    """The largest feasible scaling of a series, between `step`, which is feasible, and 1, which is not."""
    fits, beyond = step, 1.0
    while fits < STEP * beyond:
        middle = float(np.sqrt(fits * beyond))
        violations, clear = excess(outside.scaled(np.full(outside.dof, middle)))
        fits, beyond = (middle, beyond) if clear and not violations else (fits, middle)
    return outside.scaled(np.full(outside.dof, fits))


def _shares(series: Fourier, violations: Sequence[Violation]) -> np.ndarray:
    """Factor for each joint's excursion that removes its violations, shape (n,); 1 if no ratio gives it.

    No ratio gives it for torque, since the motion of any joint may load this one, and for distances.
    """
    share = np.ones(series.dof)
    for violation in violations:
        joint, center = violation.joint, series.centre[violation.joint]
        if violation.kind == "torque":
            continue
        if violation.kind in ("velocity", "acceleration", "jerk"):
            share[joint] = min(share[joint], violation.limit / violation.value * (1 - 1e-9))
        else:  # position, or the end of a stop, which shrinks at least in proportion
            away = violation.value - center
            ratio = (
                (violation.limit - center) / away if away else 0.0
            )  # a center outside the limits: the joint rests
            share[joint] = min(share[joint], ratio * (1 - 1e-9))
    return np.maximum(share, 0.0)


def _sentence(
    goal: Goal, violations: Sequence[Violation], clearances: Sequence[Clearance], series: Fourier
) -> str:
    """Why no scaling is feasible."""
    if violations:
        robot = goal.model.robot
        violation = violations[0].sentence(robot.joints, np.flatnonzero(~robot.revolute).tolist())
        margin = ""
        if violations[0].kind == "torque" and goal.spread is not None:
            share = 100 * goal.spread.share
            margin = f" (with a margin for {share:g} % of the possible arms; a fit of the arm reduces it)"
        return (
            f"{violation}{margin}, and smaller motions about the same center do not avoid it. "
            "Try a start pose or position limits that do"
        )
    nearest = min((clearance.worst(series) for clearance in clearances), key=lambda approach: approach.margin)
    return (
        f"{nearest.name}: {1e3 * nearest.margin:.0f} mm of room at {nearest.time:.2f} s, and smaller motions "
        "about the same center have no more. Try a start pose away from it"
    )
