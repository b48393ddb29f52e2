"""Shrink: a series brought inside limits that hold between samples too."""

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from exidyn.identify.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..errors import Infeasible
from ..families.fourier import Fourier
from ..limits.check import Violation, check
from ..limits.usable_limits import ranges
from .goals import Goal
from .torque_bound import TorqueBound

STEP = 0.99
"""Share of the excursion left after a step where no ratio gives the excess."""
STEPS = 150
"""Such steps at most: 0.99^150 is a fifth of the motion; what does not fit then never was near."""


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
    for _ in range(STEPS):
        violations = violations_of(series, goal, limits, tick)
        clear = all(clearance.worst(series).allowed for clearance in clearances)
        if not violations and clear:
            return series
        series = series.scaled(_shares(series, violations, clear))
    raise Infeasible(_sentence(goal, violations, clearances, series))


def _shares(series: Fourier, violations: Sequence[Violation], clear: bool) -> np.ndarray:
    """How much of each joint's excursion to keep, shape (n,)."""
    share = np.full(series.dof, 1.0 if clear else STEP)
    for violation in violations:
        joint, centre = violation.joint, series.centre[violation.joint]
        if violation.what == "torque":
            share = np.minimum(share, STEP)  # any joint's motion may be what loads this one
        elif violation.what in ("velocity", "acceleration", "jerk"):
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
