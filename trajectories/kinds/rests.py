"""Rests and the ways between them: what motions that stop now and then are made of."""

from collections.abc import Collection, Iterable

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Approach, Clearance
from ..errors import BadLimits, Infeasible
from ..families.phases import Phases
from ..limits.moves import move
from ..limits.usable_limits import require_jerk, require_tick
from ..trajectory import State, Trajectory, whole_ticks

STEPS = 240
"""Samples of a joint's range when what is clear of it is sought: on a whole turn, 1 m from the axis, what
is proved is 1.3 cm less than what there is."""


def pause(pose: np.ndarray, duration: float, tick: float) -> Phases:
    """Rest at a pose, shape (n,) [rad], for at least a duration [s], until a tick."""
    return Phases.hold(pose, whole_ticks(duration, tick))


def way(
    start: np.ndarray,
    target: np.ndarray,
    limits: Limits,
    tick: float,
    clearances: Iterable[Clearance] = (),
) -> Phases:
    """The fastest way from rest to rest, each of shape (n,) [rad]; no joint goes beyond either end.

    Raises:
        Infeasible: It collides; the message names with what and by how much.
    """
    found = move(State.at_rest(start), State.at_rest(target), limits, tick)
    require_clear("the way between two poses", found, clearances)
    return found


def require_clear(what: str, motion: Trajectory, clearances: Iterable[Clearance]) -> None:
    """Raise where a motion comes too near to anything, at any time.

    Raises:
        Infeasible: It does.
    """
    for clearance in clearances:
        nearest: Approach = clearance.worst(motion)
        if not nearest.allowed:
            raise Infeasible(
                f"{what}: {nearest.name} misses its margin by {-nearest.bound:.4g} m after "
                f"{nearest.time:.3g} s. Try other poses, a smaller range, or a smaller distance to keep"
            )


def require_clear_pose(pose: np.ndarray, clearances: Iterable[Clearance]) -> None:
    """Raise where a pose itself, shape (n,) [rad], is too near to anything.

    Raises:
        Infeasible: It is.
    """
    require_clear("the pose", Phases.hold(pose, 0.0), clearances)


def require_limits(limits: Limits, tick: float) -> None:
    """Raise unless all limits that motions from rest to rest need are given.

    Raises:
        BadLimits: A limit but the torque's that is infinite, zero or no number; no tick.
    """
    require_jerk(limits)
    require_tick(tick)
    for name, values in vars(limits).items():
        for joint in np.flatnonzero(~np.isfinite(values)):
            if name != "torque":
                raise BadLimits(
                    f"joint {joint + 1}: limit {name} is {values[joint]:g}, and must be finite. "
                    "Try `usable`, which assumes what is not given"
                )


def require_joints(joints: Collection[int], limits: Limits) -> None:
    """Raise unless each joint is one of the arm's, counted from 0, and there is one at least.

    Raises:
        BadLimits: It is not.
    """
    count = len(limits.velocity)
    for joint in joints:
        if joint not in range(count):
            raise BadLimits(f"joint number {joint}; valid are 0 to {count - 1}")
    if len(joints) == 0:
        raise BadLimits(f"no joint is to move. Try one of 0 to {count - 1}")


def require_pose(pose: np.ndarray, limits: Limits) -> np.ndarray:
    """The pose, shape (n,) [rad], as an array of numbers.

    Raises:
        BadLimits: Of another shape.
        Infeasible: A joint is outside its limits.
    """
    pose = np.asarray(pose, float)
    lower, upper = limits.position_lower, limits.position_upper
    if pose.shape != lower.shape:
        raise BadLimits(f"pose of shape {pose.shape}; expected one position for each of {len(lower)} joints")
    for joint in np.flatnonzero(~((lower <= pose) & (pose <= upper))):
        raise Infeasible(
            f"joint {joint + 1}: pose {pose[joint]:g} rad is outside its limits, {lower[joint]:g} to "
            f"{upper[joint]:g}. Try a pose inside"
        )
    return pose


def clear_range(
    limits: Limits, pose: np.ndarray, joint: int, clearances: Iterable[Clearance]
) -> tuple[float, float]:
    """Range of one joint around a pose over which, while the others rest, there is no contact [rad].

    Proved between the samples too: over a step s a margin falls by at most reach times s, so no margin
    is below 0 between two samples at which all are at least half of that.

    Raises:
        Infeasible: The pose itself is too near to anything.
    """
    clearances = tuple(clearances)
    require_clear_pose(pose, clearances)
    bounds = limits.position_lower[joint], limits.position_upper[joint]
    found = [_clear_until(limits, pose, joint, bound, clearances) for bound in bounds]
    return found[0], found[1]


def _clear_until(
    limits: Limits, pose: np.ndarray, joint: int, bound: float, clearances: tuple[Clearance, ...]
) -> float:
    """The furthest towards a bound that is proved clear."""
    positions = np.tile(pose, (STEPS + 1, 1))
    positions[:, joint] = np.linspace(pose[joint], bound, STEPS + 1)
    step = abs(bound - pose[joint]) / STEPS
    travel = np.maximum(np.abs(limits.position_lower), np.abs(limits.position_upper))
    clear = np.ones(STEPS + 1, bool)
    for clearance in clearances:
        need = 0.5 * step * clearance.reach(travel)[:, joint]
        clear &= np.all(clearance.margins(positions) >= need, axis=1)
    last = STEPS if np.all(clear) else int(np.argmin(clear)) - 1
    return float(positions[max(last, 0), joint])
