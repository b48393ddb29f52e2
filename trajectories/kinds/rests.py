"""Rests and moves between them: the parts of motions that stop now and then."""

from collections.abc import Iterable

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Approach, Clearance
from ..errors import Infeasible
from ..families.phases import Phases
from ..limits.moves import move
from ..trajectory import State, Trajectory, whole_ticks

STEPS = 240
"""Samples of a joint's range in the search for its clear part: over a full turn, 1 m from the axis, the
proven clearance is 1.3 cm less than the true one."""


def pause(pose: np.ndarray, duration: float, tick: float) -> Phases:
    """Rest at a pose, shape (n,) [rad], for a duration [s] rounded up to a sampling period."""
    return Phases.hold(pose, whole_ticks(duration, tick))


def move_clear(
    start: np.ndarray,
    target: np.ndarray,
    limits: Limits,
    tick: float,
    clearances: Iterable[Clearance] = (),
) -> Phases:
    """The fastest move from rest to rest, both of shape (n,) [rad]; no joint overshoots either pose.

    Raises:
        Infeasible: The move collides; the message names the obstacle and the distance.
    """
    motion = move(State.at_rest(start), State.at_rest(target), limits, tick)
    require_clear("the move between two poses", motion, clearances)
    return motion


def require_clear(motion_name: str, motion: Trajectory, clearances: Iterable[Clearance]) -> None:
    """Raise unless a motion keeps every clearance at all times.

    Raises:
        Infeasible: A clearance is not kept.
    """
    for clearance in clearances:
        nearest: Approach = clearance.worst(motion)
        if not nearest.allowed:
            raise Infeasible(
                f"{motion_name}: {nearest.name} misses its safety margin by {-nearest.bound:.4g} m after "
                f"{nearest.time:.3g} s. Try other poses, a smaller range, or a smaller safety margin"
            )


def require_clear_pose(pose: np.ndarray, clearances: Iterable[Clearance]) -> None:
    """Raise unless a pose, shape (n,) [rad], keeps every clearance.

    Raises:
        Infeasible: A clearance is not kept.
    """
    require_clear("the pose", Phases.hold(pose, 0.0), clearances)


def clear_range(
    limits: Limits, pose: np.ndarray, joint: int, clearances: Iterable[Clearance]
) -> tuple[float, float]:
    """Range of one joint around a pose without contact while the other joints rest [rad].

    The range is proven between samples too. Over a step s a margin falls by at most reach times s. So no
    margin is negative between two samples if all margins at both are at least half of that.

    Raises:
        Infeasible: The pose itself does not keep a clearance.
    """
    clearances = tuple(clearances)
    require_clear_pose(pose, clearances)
    bounds = limits.position_lower[joint], limits.position_upper[joint]
    lower, upper = (_clear_until(limits, pose, joint, bound, clearances) for bound in bounds)
    return lower, upper


def _clear_until(
    limits: Limits, pose: np.ndarray, joint: int, bound: float, clearances: tuple[Clearance, ...]
) -> float:
    """The position closest to a bound up to which the range is proven clear."""
    positions = np.tile(pose, (STEPS + 1, 1))
    positions[:, joint] = np.linspace(pose[joint], bound, STEPS + 1)
    step = abs(bound - pose[joint]) / STEPS
    travel = np.maximum(np.abs(limits.position_lower), np.abs(limits.position_upper))
    clear = np.ones(STEPS + 1, bool)
    for clearance in clearances:
        needed = 0.5 * step * clearance.reach(travel)[:, joint]
        clear &= np.all(clearance.margins(positions) >= needed, axis=1)
    last = STEPS if np.all(clear) else int(np.argmin(clear)) - 1
    return float(positions[max(last, 0), joint])
