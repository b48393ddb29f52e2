"""Leads: moves from rest into a motion, and from its end back to rest, by Ruckig."""

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
"""Distance beyond a position limit that counts as rounding [rad]."""


def with_leads(
    core: Trajectory, limits: Limits, tick: float, start: np.ndarray | None = None, rest: float = 1.0
) -> Sequence:
    """Rest, lead-in, the core, lead-out, and rest at the same pose.

    Args:
        core: Motion whose duration is a whole number of sampling periods.
        limits: Limits within which the leads stay and can be stopped at every sample.
        tick: Sampling period of the controller [s].
        start: Pose of the rests, shape (n,) [rad]; by default one that makes the leads short.
        rest: Least duration of each rest [s].

    Raises:
        BadLimits: The core is not a whole number of sampling periods long, or the sampling period is invalid.
        Infeasible: A lead leaves the position limits, from the start pose or from all poses that were tried.
    """
    require_tick(tick)
    ticks = core.duration / tick
    if abs(ticks - round(ticks)) > PART_OF_TICK:
        raise BadLimits(
            f"the motion lasts {core.duration:.9g} s, {ticks:.9g} sampling periods of {tick:g} s; expected a "
            f"whole number. Try a duration of {max(round(ticks), 1) * tick:.9g} s"
        )
    first, last = core.state_at(0.0), core.state_at(core.duration)
    if start is None:
        into, out = _first_possible(first, last, limits, tick)
    else:
        into, out = _leads(first, last, np.asarray(start, float), limits, tick)
    still = Phases.hold(into.position[0], whole_ticks(rest, tick))
    return Sequence((still, into, core, out, still))


def with_rests(run: Sequence, duration: float, tick: float) -> Sequence:
    """A run of `with_leads` with longer rests, so that it has a duration [s], in whole sampling periods."""
    pose = run.parts[0].state_at(0.0).position
    moving = sum(part.duration for part in run.parts[1:-1])
    ticks = round((duration - moving) / tick)
    first = Phases.hold(pose, (ticks // 2) * tick)
    return Sequence((first, *run.parts[1:-1], Phases.hold(pose, (ticks - ticks // 2) * tick)))


def lead_in(measured: State, trajectory: Trajectory, limits: Limits, tick: float) -> Phases:
    """The fastest move from a measured state to the beginning of a trajectory.

    A joint measured outside its position limits may move back inside, but no further out.

    Raises:
        BadLimits: No joint can move within the limits, or the sampling period is invalid.
        Infeasible: The lead leaves the position limits, or cannot be stopped inside them.
    """
    lead = move(measured, trajectory.state_at(0.0), limits, tick)
    _require_inside("lead-in", lead, limits, tick)
    return lead


def _leads(
    first: State, last: State, start: np.ndarray, limits: Limits, tick: float
) -> tuple[Phases, Phases]:
    """Moves from rest at a pose into a core, and from its end back to that pose."""
    rest = State.at_rest(start)
    into, out = move(rest, first, limits, tick), move(last, rest, limits, tick)
    _require_inside("lead-in", into, limits, tick)
    _require_inside("lead-out", out, limits, tick)
    return into, out


def _first_possible(first: State, last: State, limits: Limits, tick: float) -> tuple[Phases, Phases]:
    """Leads from the first pose from which they are feasible.

    The first candidate is the pose from which every joint speeds up in one go, then the first position of the
    core, then the midpoint of the two, then the middle of the limits.
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


def _require_inside(name: str, lead: Phases, limits: Limits, tick: float) -> None:
    """Raise if a lead, or a stop begun at any sample of it, leaves the position limits."""
    states = lead.every(tick)
    reach = stopping_reach(states.velocity, states.acceleration, limits)
    reached = lead.extremes().position
    lowest = np.minimum(reached.lower, (states.position + reach.lower).min(axis=0))
    highest = np.maximum(reached.upper, (states.position + reach.upper).max(axis=0))
    lower = np.minimum(limits.position_lower, lead.position[0]) - ROUNDING
    upper = np.maximum(limits.position_upper, lead.position[0]) + ROUNDING
    for joint in np.flatnonzero((lowest < lower) | (highest > upper)):
        below = lowest[joint] < lower[joint]
        value, limit = (lowest, limits.position_lower) if below else (highest, limits.position_upper)
        raise Infeasible(
            f"joint {joint + 1}: the {name} or a stop during it reaches {value[joint]:g} rad, limit "
            f"{limit[joint]:g}. Try another start pose, or begin the motion at a slower instant"
        )
