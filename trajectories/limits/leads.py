"""Leads: by Ruckig from rest into a motion, and from its end back to rest."""

from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..errors import BadLimits, Infeasible, TrajectoryError
from ..families.phases import Phases
from ..families.sequence import Sequence
from ..trajectory import PART_OF_TICK, State, Trajectory, whole_ticks
from .brake import stopping_reach
from .moves import brake, move
from .usable_limits import require_tick

ROUNDING = 1e-9
"""Radians beyond a position limit that are rounding."""


def with_leads(
    core: Trajectory, limits: Limits, tick: float, start: np.ndarray | None = None, rest: float = 1.0
) -> Sequence:
    """Rest, lead-in, the core, lead-out, rest at the same pose again.

    Args:
        core: A whole number of ticks long.
        limits: What the leads keep to, and from which every tick of them can be stopped.
        tick: Cycle of the controller [s].
        start: Pose of the rests, shape (n,) [rad]. Unless given, one that makes the leads short.
        rest: Least duration of each rest [s].

    Raises:
        BadLimits: A core that is not a whole number of ticks long, or no tick.
        Infeasible: A lead leaves the position limits, from the given start or from all that were tried.
    """
    _require_ticks(core, tick)
    first, last = core.state_at(0.0), core.state_at(core.duration)
    if start is not None:
        leads = _leads(first, last, np.asarray(start, float), limits, tick)
    else:
        leads = _first_possible(first, last, limits, tick)
    still = Phases.hold(leads.start, whole_ticks(rest, tick))
    return Sequence((still, leads.into, core, leads.out, still))


def lead_in(measured: State, trajectory: Trajectory, limits: Limits, tick: float) -> Phases:
    """The fastest way from a measured state to where a trajectory begins.

    A joint measured outside its position limits is let back in, but no further out.

    Raises:
        BadLimits: Limits within which no joint can move, or no tick.
        Infeasible: The way leaves the position limits, or cannot be stopped inside them.
    """
    way = move(measured, trajectory.state_at(0.0), limits, tick)
    _require_inside("lead-in", way, limits, tick)
    return way


class _Leads(NamedTuple):
    """From rest at a pose into a core, and from its end back to that pose."""

    start: np.ndarray
    into: Phases
    out: Phases


def _leads(first: State, last: State, start: np.ndarray, limits: Limits, tick: float) -> _Leads:
    rest = State.at_rest(start)
    leads = _Leads(start, move(rest, first, limits, tick), move(last, rest, limits, tick))
    _require_inside("lead-in", leads.into, limits, tick)
    _require_inside("lead-out", leads.out, limits, tick)
    return leads


def _first_possible(first: State, last: State, limits: Limits, tick: float) -> _Leads:
    """Leads from the first pose that can have them.

    Before all others the pose from which every joint speeds up in one go, then the first position
    itself, then the middle.
    """
    launch = brake(State(first.position, -first.velocity, first.acceleration), limits).end_state.position
    lower, upper = limits.position_lower, limits.position_upper
    with np.errstate(invalid="ignore"):
        middle = np.where(np.isfinite(upper - lower), 0.5 * (lower + upper), first.position)
    reasons: list[TrajectoryError] = []
    for pose in (launch, first.position, 0.5 * (launch + first.position), middle):
        try:
            return _leads(first, last, np.clip(pose, lower, upper), limits, tick)
        except Infeasible as error:
            reasons.append(error)
    raise Infeasible(f"no pose was found to start from; from the best guess: {reasons[0]}") from reasons[0]


def _require_inside(what: str, way: Phases, limits: Limits, tick: float) -> None:
    """Raise where a lead, or a stop begun on any tick of it, leaves the position limits."""
    states = way.every(tick)
    reach = stopping_reach(states.velocity, states.acceleration, limits)
    reached = way.extremes().position
    lowest = np.minimum(reached.lower, (states.position + reach.lower).min(axis=0))
    highest = np.maximum(reached.upper, (states.position + reach.upper).max(axis=0))
    lower = np.minimum(limits.position_lower, way.position[0]) - ROUNDING
    upper = np.maximum(limits.position_upper, way.position[0]) + ROUNDING
    for joint in np.flatnonzero((lowest < lower) | (highest > upper)):
        below = lowest[joint] < lower[joint]
        value, limit = (lowest, limits.position_lower) if below else (highest, limits.position_upper)
        raise Infeasible(
            f"joint {joint + 1}: the {what} or a stop during it reaches {value[joint]:g} rad, limit "
            f"{limit[joint]:g}. Try another start pose, or begin the motion at a slower instant"
        )


def _require_ticks(core: Trajectory, tick: float) -> None:
    require_tick(tick)
    ticks = core.duration / tick
    if abs(ticks - round(ticks)) > PART_OF_TICK:
        raise BadLimits(
            f"the motion lasts {core.duration:.9g} s, {ticks:.9g} ticks of {tick:g} s, so that its end falls "
            f"between two. Try a duration of {max(round(ticks), 1) * tick:.9g} s"
        )
