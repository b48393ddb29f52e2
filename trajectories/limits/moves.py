"""Moves: time-optimal motion within velocity, acceleration and jerk limits, by Ruckig.

No other module uses Ruckig. Its `calculate` runs locally only without waypoints (with waypoints it calls a
remote server), so none are ever set. It ignores position limits: callers that need them must check the
extremes of the result.
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
"""Time by which a joint may end before the others through rounding [s]; at a jerk of 1000 rad/s^3 this is
an acceleration of 1e-9 rad/s^2."""


def move(start: State, target: State, limits: Limits, tick: float) -> Phases:
    """The fastest move between two states; all joints arrive together, after whole sampling periods.

    A start beyond the velocity or acceleration limits is brought inside first. Position limits are not
    checked.

    Args:
        start: State at the start.
        target: State that is reached exactly, with its velocity and acceleration.
        limits: Velocity, acceleration (both directional) and jerk limits.
        tick: Sampling period of the controller [s].

    Raises:
        BadLimits: No joint can move within the limits, or the sampling period is invalid.
        Infeasible: A state is not finite, or the target exceeds the limits.
    """
    require_tick(tick)
    _require_state("start", start, limits)
    _require_state("target", target, limits)
    inputs = _input(limits)
    _require_target(target, limits)
    inputs.duration_discretization = ruckig.DurationDiscretization.Discrete
    inputs.target_position = list(target.position)
    inputs.target_velocity = list(target.velocity)
    inputs.target_acceleration = list(target.acceleration)
    _set_current(inputs, start)
    result = ruckig.Trajectory(len(limits.jerk))
    _calculate(ruckig.Ruckig(len(limits.jerk), tick), inputs, result)
    return _phases(result, start, target, round(result.duration / tick) * tick)


def brake(state: State, limits: Limits, tick: float | None = None) -> Phases:
    """The fastest stop of each joint by itself; a stopped joint rests until all have stopped.

    Args:
        state: State when the stop begins.
        limits: Acceleration (directional) and jerk limits.
        tick: Sampling period to which the duration is rounded up, if any [s].

    Raises:
        BadLimits: No joint can stop within the limits.
        Infeasible: The state is not finite.
    """
    _require_state("state", state, limits)
    inputs, result = _stop(limits), ruckig.Trajectory(len(limits.jerk))
    _set_current(inputs, state)
    _calculate(ruckig.Ruckig(len(limits.jerk)), inputs, result)
    duration = result.duration if tick is None else whole_ticks(result.duration, tick)
    rest = State.at_rest(np.array([profile.p[-1] for profile in result.profiles[0]]))
    return _phases(result, state, rest, max(duration, result.duration))


def brake_reach(velocity: np.ndarray, acceleration: np.ndarray, limits: Limits) -> Reach:
    """Most negative and most positive displacement during a stop from each of many states, by Ruckig.

    Arguments are those of `stopping_reach`. Every stop begins at position zero, because Ruckig 0.19 counts
    zero among the extremes of every stop.

    Raises:
        BadLimits: No joint can stop within the limits.
        Infeasible: A state is not finite.
    """
    inputs, result = _stop(limits), ruckig.Trajectory(len(limits.jerk))
    solver = ruckig.Ruckig(len(limits.jerk))
    lower, upper = np.empty((2, *velocity.shape))
    for row, state in enumerate(zip(velocity.tolist(), acceleration.tolist(), strict=True)):
        inputs.current_velocity, inputs.current_acceleration = state
        _calculate(solver, inputs, result)
        bounds = result.position_extrema
        lower[row], upper[row] = [bound.min for bound in bounds], [bound.max for bound in bounds]
    return Reach(lower, upper)


def _input(limits: Limits) -> ruckig.InputParameter:
    require_jerk(limits)
    inputs = ruckig.InputParameter(len(limits.jerk))
    inputs.max_velocity = list(limits.velocity)
    inputs.min_velocity = list(limits.velocity_lower)
    inputs.max_acceleration = list(limits.acceleration)
    inputs.min_acceleration = list(limits.acceleration_lower)
    inputs.max_jerk = list(limits.jerk)
    return inputs


def _stop(limits: Limits) -> ruckig.InputParameter:
    """A stop from any velocity; the target is rest, Ruckig's default."""
    inputs = _input(limits)
    inputs.control_interface = ruckig.ControlInterface.Velocity
    inputs.synchronization = ruckig.Synchronization.No
    return inputs


def _set_current(inputs: ruckig.InputParameter, state: State) -> None:
    inputs.current_position = list(state.position)
    inputs.current_velocity = list(state.velocity)
    inputs.current_acceleration = list(state.acceleration)


def _calculate(solver: ruckig.Ruckig, inputs: ruckig.InputParameter, result: ruckig.Trajectory) -> None:
    try:
        solver.calculate(inputs, result)
    except ruckig.RuckigError as error:
        text = str(error)
        joint = re.search(r"dof:? *(\d+)", text, re.IGNORECASE)
        where = f"joint {int(joint[1]) + 1}: " if joint else ""
        reason = text.replace("[ruckig]", "").strip().splitlines()[0]
        raise Infeasible(
            f"{where}no move was found: {reason}. Try a target farther from the limits"
        ) from error


def _require_state(role: str, state: State, limits: Limits) -> None:
    for name, values in state._asdict().items():
        if np.shape(values) != np.shape(limits.jerk):
            raise BadLimits(
                f"{role}: {name} of shape {np.shape(values)}; the limits have {len(limits.jerk)} joints"
            )
        for joint in np.flatnonzero(~np.isfinite(values)):
            raise Infeasible(
                f"joint {joint + 1}: {role} has {name} {values[joint]:g} {UNITS[name]}; it must be finite"
            )


def _require_target(target: State, limits: Limits) -> None:
    """Raise if the target exceeds a limit, or can only be reached from a state that does."""
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
                f"allowed are {lower[joint]:g} to {upper[joint]:g}. Try a slower target state"
            )


def _phases(result: ruckig.Trajectory, start: State, last: State, duration: float) -> Phases:
    """Pieces between the switches of all joints; a joint that ends early keeps its last state."""
    joints = [
        _joint(profile, [part[joint] for part in start], [part[joint] for part in last], duration)
        for joint, profile in enumerate(result.profiles[0])
    ]
    switches = np.unique(np.concatenate([joint.start for joint in joints]))
    columns = [joint.at(switches) for joint in joints]
    states = [np.concatenate([getattr(column, name) for column in columns], axis=1) for name in UNITS]
    return Phases(switches, duration, *states)


def _joint(profile: ruckig.Profile, start: list[float], last: list[float], duration: float) -> Phases:
    """One joint's pieces: bringing it inside the limits, the move, and rest."""
    inside, main = profile.brake, profile
    lengths = np.array([*inside.t, *main.t])
    states = np.array(
        [[*inside.p, *main.p[:7]], [*inside.v, *main.v[:7]], [*inside.a, *main.a[:7]], [*inside.j, *main.j]]
    )
    begins = np.minimum(np.concatenate([[0.0], np.cumsum(lengths)]), duration)  # rounding of the duration
    nonempty = np.append(lengths > 0.0, duration - begins[-1] > NEGLIGIBLE or not np.any(lengths))
    pieces = np.concatenate([states, np.array([[*last, 0.0]]).T], axis=1)[:, nonempty]
    pieces[:3, 0] = start
    return Phases(begins[nonempty], duration, *pieces[:, :, None])
