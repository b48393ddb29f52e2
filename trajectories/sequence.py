"""Sequence: motions one after another, and the lead-in and lead-out that join one to rest."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from exidyn.identify.robot import Limits

from .brake import stopping_reach
from .errors import BadLimits, Infeasible, NotContinuous, TrajectoryError
from .moves import brake, move
from .phases import Phases
from .trajectory import Extremes, Range, State, States, Trajectory

JOIN = 1e-6
"""Step in position [rad], velocity [rad/s] or acceleration [rad/s^2] between two parts that is rounding: a
hundredth of what a 16 bit encoder sees, a hundred times what Ruckig misses its target by."""
ROUNDING = 1e-9
"""Radians beyond a position limit that are rounding."""
PART_OF_TICK = 1e-6
"""Share of a tick by which a duration may miss a whole number of ticks, as in `Trajectory.every`."""


@dataclass(frozen=True, eq=False)
class Sequence(Trajectory):
    """Motions one after another, each of which begins as the one before it ends.

    Attributes:
        parts: At least one.
    """

    parts: tuple[Trajectory, ...]

    def __post_init__(self) -> None:
        if not self.parts or len({part.dof for part in self.parts}) != 1:
            raise NotContinuous(
                f"a sequence of parts with {[part.dof for part in self.parts]} joints; "
                "expected one part or more, all of the same arm"
            )
        for number, (before, after) in enumerate(zip(self.parts, self.parts[1:], strict=False), start=1):
            _require_join(number, _state_at(before, before.duration), _state_at(after, 0.0))

    @property
    def duration(self) -> float:
        return float(self.begins[-1])

    @property
    def dof(self) -> int:
        return self.parts[0].dof

    @property
    def begins(self) -> np.ndarray:
        """When each part begins, and when the last ends, shape (parts + 1,) [s]."""
        return np.concatenate([[0.0], np.cumsum([part.duration for part in self.parts])])

    def at(self, time: np.ndarray) -> States:
        """States at given times; at a join, those of the part which begins there."""
        time = self.inside(time)
        begins = self.begins
        owner = np.clip(np.searchsorted(begins, time, side="right") - 1, 0, len(self.parts) - 1)
        columns = np.empty((4, len(time), self.dof))
        for index in np.unique(owner):
            mine = owner == index
            columns[:, mine] = self.parts[index].at(time[mine] - begins[index])[1:]
        return States(time, *columns)

    def extremes(self) -> Extremes:
        found = [part.extremes() for part in self.parts]
        return Extremes(*(_widest(ranges, self.begins) for ranges in zip(*found, strict=True)))


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
    first, last = _state_at(core, 0.0), _state_at(core, core.duration)
    if start is not None:
        leads = _leads(first, last, np.asarray(start, float), limits, tick)
    else:
        leads = _first_possible(first, last, limits, tick)
    pause = np.ceil(rest / tick - PART_OF_TICK) * tick
    still = Phases.hold(leads.start, pause)
    return Sequence((still, leads.into, core, leads.out, still))


def lead_in(measured: State, trajectory: Trajectory, limits: Limits, tick: float) -> Phases:
    """The fastest way from a measured state to where a trajectory begins.

    A joint measured outside its position limits is let back in, but no further out.

    Raises:
        BadLimits: Limits within which no joint can move, or no tick.
        Infeasible: The way leaves the position limits, or cannot be stopped inside them.
    """
    way = move(measured, _state_at(trajectory, 0.0), limits, tick)
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
    for joint in range(way.dof):
        below = lowest[joint] < lower[joint]
        if below or highest[joint] > upper[joint]:
            value, limit = (lowest, limits.position_lower) if below else (highest, limits.position_upper)
            raise Infeasible(
                f"joint {joint + 1}: the {what} or a stop during it reaches {value[joint]:g} rad, limit "
                f"{limit[joint]:g}. Try another start pose, or begin the motion at a slower instant"
            )


def _require_ticks(core: Trajectory, tick: float) -> None:
    if not 0.0 < tick < np.inf:
        raise BadLimits(f"a tick of {tick:g} s; it must be above 0")
    ticks = core.duration / tick
    if abs(ticks - round(ticks)) > PART_OF_TICK:
        raise BadLimits(
            f"the motion lasts {core.duration:.9g} s, {ticks:.9g} ticks of {tick:g} s, so that its end falls "
            f"between two. Try a duration of {max(round(ticks), 1) * tick:.9g} s"
        )


def _require_join(number: int, before: State, after: State) -> None:
    for name, unit, left, right in zip(
        State._fields, ("rad", "rad/s", "rad/s^2"), before, after, strict=True
    ):
        for joint in np.flatnonzero(~(np.abs(right - left) <= JOIN)):
            raise NotContinuous(
                f"joint {joint + 1}: {name} jumps from {left[joint]:.9g} to {right[joint]:.9g} {unit} "
                f"between parts {number} and {number + 1}; a part must begin as the one before it ends. "
                "Try a move between"
            )


def _state_at(trajectory: Trajectory, time: float) -> State:
    return trajectory.at(np.array([time])).state(0)


def _widest(ranges: tuple[Range, ...], begins: np.ndarray) -> Range:
    """Smallest and largest of all parts' ranges; times from the start of the sequence."""
    lower, upper, lower_time, upper_time = np.moveaxis(np.array(ranges), 1, 0)
    low, high, joint = np.argmin(lower, axis=0), np.argmax(upper, axis=0), np.arange(lower.shape[1])
    return Range(
        lower[low, joint],
        upper[high, joint],
        lower_time[low, joint] + begins[low],
        upper_time[high, joint] + begins[high],
    )
