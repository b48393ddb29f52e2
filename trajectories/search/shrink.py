"""Shrink: a series brought inside limits that hold between samples too."""

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
"""Share of the excursion left after the first step where no ratio gives the excess, and how near to the
largest that fits it ends. Each further step is the square of the one before."""
LEAST = 0.2
"""Share of the excursion at which it ends: what does not fit then never was near."""
MOST = 10
"""Steps by ratios at most: each brings its joint inside, and more shows that none helps."""


def inside_kinematics(series: Fourier, limits: Limits, share: float = 1.0) -> Fourier:
    """Each joint's excursion scaled to `share` of what its tightest limit allows; up or down."""
    room = []
    for (name, (lower, upper)), found in zip(ranges(limits).items(), series.extremes(), strict=True):
        about = series.centre if name == "position" else 0.0
        room += [(upper - about) / (found.upper - about), (lower - about) / (found.lower - about)]
    return series.scaled(share * np.min(room, axis=0))


def violations_of(series: Fourier, goal: Goal, limits: Limits, tick: float) -> list[Violation]:
    """What a series does that the limits forbid, between samples too, in every run of the goal."""
    bound = TorqueBound(goal.model, limits.torque, goal.payloads, goal.spread)
    return [v for payload in goal.payloads for v in check(series, limits, tick, bound.of(payload))]


def tightened(limits: Limits, violations: Sequence[Violation]) -> Limits:
    """Limits nearer by as much as each was passed: rates and torques as a share, positions in radians."""
    changed = {f.name: np.array(getattr(limits, f.name)) for f in fields(limits)}
    for what, joint, _, value, limit in violations:
        side = "lower" if value < limit else "upper"
        if what in ("position", "stop"):
            changed[f"position_{side}"][joint] -= value - limit
        elif what in ("velocity", "acceleration") and side == "lower":
            changed[f"{what}_lower"][joint] *= limit / value
        elif what in changed:
            changed[what][joint] *= limit / value
    return replace(limits, **changed)


def shrink_inside(
    series: Fourier,
    goal: Goal,
    limits: Limits,
    clearances: Sequence[Clearance],
    tick: float,
) -> Fourier:
    """The series, no larger than it was, inside every limit at every time.

    Raises:
        Infeasible: Not even a small motion about its centre keeps to the limits.
    """

    def excess(of: Fourier) -> tuple[list[Violation], bool]:
        return violations_of(of, goal, limits, tick), _clear(of, clearances)

    for _ in range(MOST):
        violations, clear = excess(series)
        shares = _shares(series, violations)
        if np.all(shares == 1.0):
            break
        series = series.scaled(shares)
    if not violations and clear:
        return series
    step, left = STEP, STEP
    while left >= LEAST:
        outside, series = series, series.scaled(np.full(series.dof, step))
        violations, clear = excess(series)
        if not violations and clear:
            return _largest(outside, step, excess)
        step **= 2
        left *= step
    raise Infeasible(_sentence(goal, violations, clearances, series))


def _clear(series: Fourier, clearances: Sequence[Clearance]) -> bool:
    return all(clearance.worst(series).allowed for clearance in clearances)


def _largest(
    outside: Fourier, step: float, excess: Callable[[Fourier], tuple[list[Violation], bool]]
) -> Fourier:
    """Between a series that does not fit and `step` of it, which does: the largest that fits, to a `STEP`."""
    fits, beyond = step, 1.0
    while fits < STEP * beyond:
        middle = float(np.sqrt(fits * beyond))
        violations, clear = excess(outside.scaled(np.full(outside.dof, middle)))
        fits, beyond = (middle, beyond) if clear and not violations else (fits, middle)
    return outside.scaled(np.full(outside.dof, fits))


def _shares(series: Fourier, violations: Sequence[Violation]) -> np.ndarray:
    """How much of each joint's excursion to keep where a ratio says it, else 1; shape (n,).

    None does of torque, with which the motion of any joint may load this one, and of distances.
    """
    share = np.ones(series.dof)
    for violation in violations:
        joint, centre = violation.joint, series.centre[violation.joint]
        if violation.what == "torque":
            continue
        if violation.what in ("velocity", "acceleration", "jerk"):
            share[joint] = min(share[joint], violation.limit / violation.value * (1 - 1e-9))
        else:  # position, or where a stop ends, which moves at least in proportion
            away = violation.value - centre
            ratio = (violation.limit - centre) / away if away else 0.0  # a centre outside: it stands still
            share[joint] = min(share[joint], ratio * (1 - 1e-9))
    return np.maximum(share, 0.0)


def _sentence(
    goal: Goal, violations: Sequence[Violation], clearances: Sequence[Clearance], series: Fourier
) -> str:
    """Why nothing fits."""
    if violations:
        robot = goal.model.robot
        what = violations[0].sentence(robot.joints, np.flatnonzero(~robot.revolute).tolist())
        unsure = ""
        if violations[0].what == "torque" and goal.spread is not None:
            share = 100 * goal.spread.share
            unsure = (
                f" (with margin for {share:g} % of the arms that are possible; with --from fit.json less)"
            )
        return (
            f"{what}{unsure}, and so it is for ever smaller motions about the same centre. "
            "Try a start pose or position limits that avoid it"
        )
    nearest = min((clearance.worst(series) for clearance in clearances), key=lambda one: one.margin)
    return (
        f"{nearest.name}: {1e3 * nearest.margin:.0f} mm of room at {nearest.time:.2f} s, and no more in ever "
        "smaller motions about the same centre. Try a start pose away from it"
    )
