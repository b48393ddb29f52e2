"""Moves: time-optimal motion within velocity, acceleration and jerk, by Ruckig.

No other module knows Ruckig. Its `calculate` runs on this machine only as long as no waypoints are set
(with waypoints it asks a remote server), so none ever are. It also ignores position limits: code that needs
those kept must look at the extremes of what comes back.
"""

import re

import numpy as np
import ruckig

from exidyn.identification.arm.robot import Limits

from ..errors import BadLimits, Infeasible
from ..families.phases import Phases
from ..trajectory import UNITS, State, whole_ticks
from .brake import Reach
from .usable_limits import ranges, require_jerk, require_tick

NEGLIGIBLE = 1e-12
"""Seconds by which a joint may end before the others through rounding alone; at a jerk of 1000 rad/s^3
that is 1e-9 rad/s^2 of acceleration."""


def move(start: State, target: State, limits: Limits, tick: float) -> Phases:
    """The fastest way from a state to a state; all joints arrive at once, on a whole number of ticks.

    A start beyond the velocity or acceleration limits is brought inside first. Position limits are not
    looked at.

    Args:
        start: Where the joints are and how they move.
        target: Reached exactly, its velocity and acceleration too.
        limits: Velocity, acceleration (both directional) and jerk.
        tick: Cycle of the controller [s].

    Raises:
        BadLimits: Limits within which no joint can move, or a tick that is none.
        Infeasible: A state that is not a number, or a target beyond the limits.
    """
    require_tick(tick)
    _require_state("start", start, limits)
    _require_state("target", target, limits)
    question = _question(limits)
    _require_target(target, limits)
    question.duration_discretization = ruckig.DurationDiscretization.Discrete
    question.target_position = list(target.position)
    question.target_velocity = list(target.velocity)
    question.target_acceleration = list(target.acceleration)
    _begin(question, start)
    answer = ruckig.Trajectory(len(limits.jerk))
    _calculate(ruckig.Ruckig(len(limits.jerk), tick), question, answer)
    return _phases(answer, start, target, round(answer.duration / tick) * tick)


def brake(state: State, limits: Limits, tick: float | None = None) -> Phases:
    """The fastest stop of each joint by itself; wherever it comes to rest, it stays until all do.

    Args:
        state: How the joints move when the stop begins.
        limits: Acceleration (directional) and jerk.
        tick: If given, rest lasts until the next tick after the last joint has stopped [s].

    Raises:
        BadLimits: Limits within which no joint can stop.
        Infeasible: A state that is not a number.
    """
    _require_state("state", state, limits)
    question, answer = _stop(limits), ruckig.Trajectory(len(limits.jerk))
    _begin(question, state)
    _calculate(ruckig.Ruckig(len(limits.jerk)), question, answer)
    duration = answer.duration if tick is None else whole_ticks(answer.duration, tick)
    rest = State.at_rest(np.array([profile.p[-1] for profile in answer.profiles[0]]))
    return _phases(answer, state, rest, max(duration, answer.duration))


def brake_reach(velocity: np.ndarray, acceleration: np.ndarray, limits: Limits) -> Reach:
    """How far a stop goes down and up from where it begins, for each of many states, by Ruckig itself.

    Begun at zero, because Ruckig 0.19 counts position zero among the extremes of every stop.

    Args:
        velocity: Shape (t, n) [rad/s].
        acceleration: Shape (t, n) [rad/s^2].
        limits: Acceleration (directional) and jerk.

    Raises:
        BadLimits: Limits within which no joint can stop.
        Infeasible: A state that is not a number.
    """
    question, answer = _stop(limits), ruckig.Trajectory(len(limits.jerk))
    solver = ruckig.Ruckig(len(limits.jerk))
    lower, upper = np.empty((2, *velocity.shape))
    for row, state in enumerate(zip(velocity.tolist(), acceleration.tolist(), strict=True)):
        question.current_velocity, question.current_acceleration = state
        _calculate(solver, question, answer)
        bounds = answer.position_extrema
        lower[row], upper[row] = [bound.min for bound in bounds], [bound.max for bound in bounds]
    return Reach(lower, upper)


def _question(limits: Limits) -> ruckig.InputParameter:
    require_jerk(limits)
    question = ruckig.InputParameter(len(limits.jerk))
    question.max_velocity = list(limits.velocity)
    question.min_velocity = list(limits.velocity_lower)
    question.max_acceleration = list(limits.acceleration)
    question.min_acceleration = list(limits.acceleration_lower)
    question.max_jerk = list(limits.jerk)
    return question


def _stop(limits: Limits) -> ruckig.InputParameter:
    """A stop from any velocity; the target is rest, Ruckig's default."""
    question = _question(limits)
    question.control_interface = ruckig.ControlInterface.Velocity
    question.synchronization = ruckig.Synchronization.No
    return question


def _begin(question: ruckig.InputParameter, state: State) -> None:
    question.current_position = list(state.position)
    question.current_velocity = list(state.velocity)
    question.current_acceleration = list(state.acceleration)


def _calculate(solver: ruckig.Ruckig, question: ruckig.InputParameter, answer: ruckig.Trajectory) -> None:
    try:
        solver.calculate(question, answer)
    except ruckig.RuckigError as error:
        text = str(error)
        joint = re.search(r"dof:? *(\d+)", text, re.IGNORECASE)
        where = f"joint {int(joint[1]) + 1}: " if joint else ""
        reason = text.replace("[ruckig]", "").strip().splitlines()[0]
        raise Infeasible(
            f"{where}no move was found: {reason}. Try a target further from the limits"
        ) from error


def _require_state(what: str, state: State, limits: Limits) -> None:
    for name, values in state._asdict().items():
        if np.shape(values) != np.shape(limits.jerk):
            raise BadLimits(
                f"{what}: {name} of shape {np.shape(values)}; the limits have {len(limits.jerk)} joints"
            )
        for joint in np.flatnonzero(~np.isfinite(values)):
            raise Infeasible(
                f"joint {joint + 1}: {what} has {name} {values[joint]:g} {UNITS[name]}; it must be a number"
            )


def _require_target(target: State, limits: Limits) -> None:
    """Raise where the target is beyond a limit, or can only be reached from beyond one."""
    with np.errstate(divide="ignore"):
        gained = 0.5 * target.acceleration * np.abs(target.acceleration) / limits.jerk
    checks = (
        ("velocity", "", target.velocity),
        ("acceleration", "", target.acceleration),
        ("velocity", " before its acceleration", target.velocity - gained),
    )
    for name, when, values in checks:
        lower, upper = ranges(limits)[name]
        for joint in np.flatnonzero((values < lower) | (values > upper)):
            raise Infeasible(
                f"joint {joint + 1}: {name}{when} of the target is {values[joint]:g} {UNITS[name]}, "
                f"allowed are {lower[joint]:g} to {upper[joint]:g}. Try a slower target"
            )


def _phases(answer: ruckig.Trajectory, start: State, last: State, duration: float) -> Phases:
    """Pieces on the union of all joints' switches; a joint that ends early stays in the last state."""
    joints = [
        _joint(profile, [part[joint] for part in start], [part[joint] for part in last], duration)
        for joint, profile in enumerate(answer.profiles[0])
    ]
    switches = np.unique(np.concatenate([joint.start for joint in joints]))
    columns = [joint.at(switches) for joint in joints]
    position, velocity, acceleration, jerk = (
        np.concatenate([getattr(column, name) for column in columns], axis=1)
        for name in ("position", "velocity", "acceleration", "jerk")
    )
    return Phases(switches, duration, position, velocity, acceleration, jerk)


def _joint(profile: ruckig.Profile, start: list[float], last: list[float], duration: float) -> Phases:
    """One joint's pieces: bringing it inside the limits, the move, and rest."""
    inside, way = profile.brake, profile
    lengths = np.array([*inside.t, *way.t])
    states = np.array(
        [[*inside.p, *way.p[:7]], [*inside.v, *way.v[:7]], [*inside.a, *way.a[:7]], [*inside.j, *way.j]]
    )
    begins = np.minimum(np.concatenate([[0.0], np.cumsum(lengths)]), duration)  # rounding of the tick
    real = np.append(lengths > 0.0, duration - begins[-1] > NEGLIGIBLE or not np.any(lengths))
    pieces = np.concatenate([states, np.array([[*last, 0.0]]).T], axis=1)[:, real]
    pieces[:3, 0] = start
    return Phases(begins[real], duration, *pieces[:, :, None])
