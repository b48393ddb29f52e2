"""Slow sweeps at constant velocity: the friction curve of a joint, and how it depends on load."""

from collections.abc import Callable, Collection, Iterable
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..errors import BadLimits, Infeasible
from ..families.phases import Phases
from ..families.sequence import Sequence
from ..trajectory import PART_OF_TICK, State, Trajectory, whole_ticks
from .rests import clear_range, move_clear, pause, require_joints, require_limits, require_pose

SLOWEST, FASTEST = 0.01, 0.6
"""Shares of the velocity limit. A hundredth, about 0.02 rad/s, is below the Stribeck velocity (0.1 rad/s,
within a factor of five), where boundary friction dominates. At six tenths the lubricant film carries the
load, and half of the range remains for the cruise."""
SPEEDS = 6
"""Number of speeds, evenly spaced in the logarithm: two or three on either side of the Stribeck velocity."""
CRUISE = 1.0
"""Least cruise at speeds that are chosen here [s]: 20 periods of a 20 Hz low-pass to average over."""
SHORTEST = 0.25
"""Least cruise at requested speeds [s]: in less than 5 periods of that filter nothing settles."""
LONGEST = 10.0
"""Longest cruise [s]: at 0.02 rad/s and a gear ratio of 100, three motor turns, and so three periods of a
ripple with one period per turn."""
REST = 0.5
"""Rest before each pass [s]: long enough for vibrations after a stop to die out."""


def constant_velocity_sweeps(
    limits: Limits,
    joints: Collection[int],
    pose: np.ndarray,
    tick: float,
    velocities: np.ndarray | None = None,
    ranges: np.ndarray | None = None,
    clearances: Collection[Clearance] = (),
    longest: float = LONGEST,
    rest: float = REST,
    begin: Callable[[int], None] = lambda joint: None,
) -> Sequence:
    """Sweep joints in turn, forward and backward, at constant velocities, from rest to rest at a pose.

    Friction is half the difference of the forward and backward torques at the same position, where gravity
    is equal. With several poses of the other joints, the sweep is repeated under several gear loads.

    Args:
        limits: Limits, finite except for torque.
        joints: Joints that sweep, counted from 0.
        pose: Pose of the joints that do not sweep, shape (n,) [rad], or several poses in turn, shape (m, n).
        tick: Sampling period of the controller [s].
        velocities: Velocities, shape (k,) or (joints, k) [rad/s]. By default six for each joint, from a
            hundredth to six tenths of its limit, or less if its range is too short to cruise for a second.
        ranges: Range within which each joint may sweep, shape (joints, 2) [rad]; its limits by default.
        clearances: Clearances to keep; the range shrinks to the clear range.
        longest: Longest cruise [s]. The duration of a fast sweep follows from its range.
        rest: Rest before each pass [s].
        begin: Called with each joint before its sweeps are made, as collision checks take time.

    Raises:
        BadLimits: The limits, joints, velocities or ranges are invalid.
        Infeasible: A pose is outside the limits or not clear, a range is too short, or a velocity exceeds
            its limit.
    """
    require_limits(limits, tick)
    require_joints(joints, limits)
    poses = [require_pose(row, limits) for row in np.atleast_2d(np.asarray(pose, float))]
    speeds = _speeds(velocities, len(joints))
    allowed = np.asarray(ranges, float)
    if ranges is not None and allowed.shape != (len(joints), 2):
        raise BadLimits(f"ranges of shape {allowed.shape}; expected ({len(joints)}, 2)")
    parts: list[Trajectory] = []
    for current, following in zip(poses, [*poses[1:], poses[0]], strict=True):
        for place, joint in enumerate(joints):
            begin(joint)
            room = _room(limits, joint, current, None if ranges is None else allowed[place], clearances)
            joint_speeds = _default_speeds(limits, room, joint, tick) if speeds is None else speeds[place]
            passes = [_pass(limits, room, current, joint, float(v), tick, longest) for v in joint_speeds]
            parts += _joined(current, joint, passes, limits, tick, rest)
        parts.append(move_clear(current, following, limits, tick, clearances))
    return Sequence(tuple(part for part in parts if part.duration > 0.0))


def _room(
    limits: Limits,
    joint: int,
    pose: np.ndarray,
    allowed: np.ndarray | None,
    clearances: Collection[Clearance],
) -> tuple[float, float]:
    """Clear range of a joint around a pose, within the `allowed` range, shape (2,) [rad]."""
    lower, upper = clear_range(limits, pose, joint, clearances)
    if allowed is not None:
        lower, upper = max(lower, float(allowed[0])), min(upper, float(allowed[1]))
    if not lower < upper:
        raise Infeasible(
            f"joint {joint + 1}: there is no room to sweep from {lower:g} to {upper:g} rad. "
            "Try a wider range, or a pose with more room around it"
        )
    return lower, upper


class _Pass(NamedTuple):
    """One pass of a sweep: speed up, cruise, slow down, each in whole sampling periods.

    Attributes:
        begin: Position of the joint at rest before the forward pass [rad].
        velocity: Velocity of the cruise, above zero [rad/s].
        build_up: Time in which the acceleration rises or falls [s].
        hold: Time for which the acceleration is held [s].
        cruise: Duration of the cruise [s].
    """

    begin: float
    velocity: float
    build_up: float
    hold: float
    cruise: float

    @property
    def travel(self) -> float:
        """Distance from rest to rest [rad]; the mean velocity of speeding up and slowing down is half."""
        return self.velocity * (2 * self.build_up + self.hold + self.cruise)

    def phases(self, pose: np.ndarray, joint: int, forward: bool) -> Phases:
        """The motion, with the other joints at rest at a pose, shape (n,) [rad]."""
        start, jerks = pose.copy(), np.zeros((7, len(pose)))
        start[joint] = self.begin if forward else self.begin + self.travel
        jerk = self.velocity / (self.build_up * (self.build_up + self.hold))
        jerks[[0, 2, 4, 6], joint] = (1.0 if forward else -1.0) * jerk * np.array([1.0, -1.0, -1.0, 1.0])
        up = [self.build_up, self.hold, self.build_up]
        return Phases.of_jerks(State.at_rest(start), np.array([*up, self.cruise, *up]), jerks)


def _speed_up(limits: Limits, joint: int, velocity: float, tick: float) -> tuple[float, float]:
    """Times to build up and to hold the acceleration, such that every switch falls on a sample [s].

    This is not the fastest speed-up: one that ended between two samples would spoil a sample of the cruise,
    and Ruckig swings back first if it must end on a sample after a fixed distance.
    """
    most = min(limits.acceleration[joint], -limits.acceleration_lower[joint])
    jerk = float(limits.jerk[joint])
    build_up = whole_ticks(min(most / jerk, np.sqrt(velocity / jerk)), tick)
    total = whole_ticks(max(velocity / most, velocity / (jerk * build_up), build_up), tick)
    return build_up, total - build_up


def _pass(
    limits: Limits,
    room: tuple[float, float],
    pose: np.ndarray,
    joint: int,
    velocity: float,
    tick: float,
    longest: float,
) -> _Pass:
    """A pass within the range `room`, centered on the pose as far as the range allows."""
    allowed = min(limits.velocity[joint], -limits.velocity_lower[joint])
    if not 0.0 < velocity <= allowed:
        raise Infeasible(
            f"joint {joint + 1}: the velocity of a sweep is {velocity:g} rad/s; its limit in the slower "
            f"direction is {allowed:g}. Try a velocity above 0 and below the limit"
        )
    build_up, hold = _speed_up(limits, joint, velocity, tick)
    available = (room[1] - room[0]) / velocity - (2 * build_up + hold)
    cruise = float(np.floor(min(available, longest) / tick + PART_OF_TICK) * tick)
    if cruise < SHORTEST:
        raise Infeasible(
            f"joint {joint + 1}: at {velocity:g} rad/s it cruises for {max(cruise, 0.0):.3g} s, and at least "
            f"{SHORTEST:g} s are needed, from {room[0]:g} to {room[1]:g} rad, within {longest:g} s. "
            "Try a slower sweep, a wider range or a longer time"
        )
    sweep = _Pass(0.0, velocity, build_up, hold, cruise)
    begin = min(max(pose[joint] - sweep.travel / 2, room[0]), room[1] - sweep.travel)
    return sweep._replace(begin=max(float(begin), room[0]))


def _default_speeds(limits: Limits, room: tuple[float, float], joint: int, tick: float) -> np.ndarray:
    """Velocities at which a joint can sweep the range `room`, shape (k,) [rad/s]."""
    full = min(limits.velocity[joint], -limits.velocity_lower[joint])
    candidates = full * np.geomspace(FASTEST, SLOWEST, 100)
    travel = [_Pass(0.0, v, *_speed_up(limits, joint, v, tick), CRUISE).travel for v in candidates]
    fits = candidates[np.array(travel) <= room[1] - room[0]]
    if len(fits) == 0:
        raise Infeasible(
            f"joint {joint + 1}: from {room[0]:g} to {room[1]:g} rad there is no room to cruise for "
            f"{CRUISE:g} s, even at {candidates[-1]:.3g} rad/s. Try a wider range or slower velocities"
        )
    return np.geomspace(candidates[-1], fits[0], SPEEDS)


def _speeds(velocities: np.ndarray | None, joints: int) -> np.ndarray | None:
    """Velocities of each joint, shape (joints, k) [rad/s]."""
    if velocities is None:
        return None
    speeds = np.asarray(velocities, float)
    if speeds.ndim == 1:
        speeds = np.tile(speeds, (joints, 1))
    if speeds.ndim != 2 or len(speeds) != joints or speeds.size == 0:
        raise BadLimits(f"velocities of shape {np.shape(velocities)}; expected (k,) or ({joints}, k)")
    return speeds


def _joined(
    pose: np.ndarray, joint: int, passes: Iterable[_Pass], limits: Limits, tick: float, rest: float
) -> list[Trajectory]:
    """Passes of one joint from rest to rest at a pose; the joint stays in its clear range."""
    parts: list[Trajectory] = []
    at = pose
    for sweep in passes:
        begin, end = pose.copy(), pose.copy()
        begin[joint], end[joint] = sweep.begin, sweep.begin + sweep.travel
        parts += [
            move_clear(at, begin, limits, tick),
            pause(begin, rest, tick),
            sweep.phases(pose, joint, True),
        ]
        parts += [pause(end, rest, tick), sweep.phases(pose, joint, False)]
        at = begin
    return [*parts, move_clear(at, pose, limits, tick)]
