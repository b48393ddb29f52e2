"""Slow sweeps at constant velocity: the friction curve of a joint, and how it answers to load."""

from collections.abc import Callable, Collection, Iterable
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..errors import BadLimits, Infeasible
from ..families.phases import Phases
from ..families.sequence import Sequence
from ..trajectory import PART_OF_TICK, State, Trajectory, whole_ticks
from .rests import clear_range, pause, require_joints, require_limits, require_pose, way

SLOWEST, FASTEST = 0.01, 0.6
"""Shares of the velocity limit. A hundredth, some 0.02 rad/s, is on the side of the Stribeck bend (0.1 rad/s,
give or take a factor of five) where boundary friction rules; at six tenths the film carries, and half of the
range is still left to cruise on."""
SPEEDS = 6
"""Evenly spaced in the logarithm: two or three on either side of the bend, wherever it is."""
CRUISE = 1.0
"""Least cruise of the speeds that are chosen here [s]: 20 periods of a low-pass at 20 Hz to average over."""
SHORTEST = 0.25
"""Least cruise of speeds that were asked for [s]; in less than 5 periods of that filter nothing settles."""
LONGEST = 10.0
"""Longest cruise [s]: at 0.02 rad/s and a gear of 100, three turns of the motor and so three periods of what
ripples once a turn."""
REST = 0.5
"""Rest before each pass [s]: what the arm swings after a stop has died out."""


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
    """Joints one after another go forth and back at constant velocities; begins and ends at rest at a pose.

    Friction is half the difference of the torques forth and back at the same place, where gravity is the
    same. Several poses of the other joints give the same sweep under several loads of the gear.

    Args:
        limits: Finite but for the torque.
        joints: Which move, counted from 0.
        pose: Pose of all joints where none sweeps, shape (n,) [rad], or several one after another, (m, n).
        tick: Cycle of the controller [s].
        velocities: Shape (k,), or (joints, k) [rad/s]. Unless given, six of each joint from a hundredth to
            six tenths of its limit, less where its range is too short to cruise for a second.
        ranges: Where each of the joints may sweep, shape (joints, 2) [rad]; its limits unless given.
        clearances: What to keep clear of; the range shrinks to what is.
        longest: Longest time of each cruise [s]. The duration of a fast sweep follows from its range.
        rest: Before each pass [s].
        begin: Called with each joint before its sweeps are made; to keep clear of geometry takes time.

    Raises:
        BadLimits: Limits, joints, velocities or ranges that are none.
        Infeasible: A pose outside the limits or not clear, a range too short, a velocity beyond its limit.
    """
    require_limits(limits, tick)
    require_joints(joints, limits)
    poses = [require_pose(row, limits) for row in np.atleast_2d(np.asarray(pose, float))]
    speeds = _speeds(velocities, len(joints))
    allowed = np.asarray(ranges, float)
    if ranges is not None and allowed.shape != (len(joints), 2):
        raise BadLimits(f"ranges of shape {allowed.shape}; expected ({len(joints)}, 2)")
    parts: list[Trajectory] = []
    for here, following in zip(poses, [*poses[1:], poses[0]], strict=True):
        for place, joint in enumerate(joints):
            begin(joint)
            room = _room(limits, joint, here, None if ranges is None else allowed[place], clearances)
            own = _chosen(limits, room, joint, tick) if speeds is None else speeds[place]
            passes = [_pass(limits, room, here, joint, float(v), tick, longest) for v in own]
            parts += _joined(here, joint, passes, limits, tick, rest)
        parts.append(way(here, following, limits, tick, clearances))
    return Sequence(tuple(part for part in parts if part.duration > 0.0))


def _room(
    limits: Limits,
    joint: int,
    pose: np.ndarray,
    allowed: np.ndarray | None,
    clearances: Collection[Clearance],
) -> tuple[float, float]:
    """Range of a joint around a pose, clear of everything and within what is `allowed`, shape (2,) [rad]."""
    lower, upper = clear_range(limits, pose, joint, clearances)
    if allowed is not None:
        lower, upper = max(lower, float(allowed[0])), min(upper, float(allowed[1]))
    if not lower < upper:
        raise Infeasible(
            f"joint {joint + 1}: no room to sweep, {lower:g} to {upper:g} rad. Try a wider range, or "
            "a pose with more room around it"
        )
    return lower, upper


class _Pass(NamedTuple):
    """One way of a sweep: speed up, cruise, slow down, each in whole ticks.

    Attributes:
        begin: Position of the joint at rest before it goes forth [rad].
        velocity: Velocity of the cruise, above zero [rad/s].
        build_up: Time in which the acceleration comes or goes [s].
        hold: Time for which it is held [s].
        cruise: [s].
    """

    begin: float
    velocity: float
    build_up: float
    hold: float
    cruise: float

    @property
    def travel(self) -> float:
        """From rest to rest [rad]: speeding up and slowing down go at half the velocity on average."""
        return self.velocity * (2 * self.build_up + self.hold + self.cruise)

    def phases(self, pose: np.ndarray, joint: int, forth: bool) -> Phases:
        """The motion, with the other joints at rest at a pose, shape (n,) [rad]."""
        start, jerks = pose.copy(), np.zeros((7, len(pose)))
        start[joint] = self.begin if forth else self.begin + self.travel
        jerk = self.velocity / (self.build_up * (self.build_up + self.hold))
        jerks[[0, 2, 4, 6], joint] = (1.0 if forth else -1.0) * jerk * np.array([1.0, -1.0, -1.0, 1.0])
        up = [self.build_up, self.hold, self.build_up]
        return Phases.of_jerks(State.at_rest(start), np.array([*up, self.cruise, *up]), jerks)


def _speed_up(limits: Limits, joint: int, velocity: float, tick: float) -> tuple[float, float]:
    """Times to build up and to hold the acceleration, so that every switch falls on a tick [s].

    Not the fastest: a speed-up that ends between two ticks would leave a tick of the cruise that is none,
    and Ruckig, asked to end on a tick after a given way, swings back first.
    """
    most = min(limits.acceleration[joint], -limits.acceleration_lower[joint])
    jerk = float(limits.jerk[joint])
    build_up = whole_ticks(min(most / jerk, np.sqrt(velocity / jerk)), tick)
    whole = whole_ticks(max(velocity / most, velocity / (jerk * build_up), build_up), tick)
    return build_up, whole - build_up


def _pass(
    limits: Limits,
    room: tuple[float, float],
    pose: np.ndarray,
    joint: int,
    velocity: float,
    tick: float,
    longest: float,
) -> _Pass:
    """A pass within a room, as near to the pose's own position as there is room for."""
    allowed = min(limits.velocity[joint], -limits.velocity_lower[joint])
    if not 0.0 < velocity <= allowed:
        raise Infeasible(
            f"joint {joint + 1}: a sweep at {velocity:g} rad/s; its limit is {allowed:g}, in the slower "
            "direction. Try a velocity above 0 and below that"
        )
    build_up, hold = _speed_up(limits, joint, velocity, tick)
    most = (room[1] - room[0]) / velocity - (2 * build_up + hold)
    cruise = float(np.floor(min(most, longest) / tick + PART_OF_TICK) * tick)
    if cruise < SHORTEST:
        raise Infeasible(
            f"joint {joint + 1}: at {velocity:g} rad/s it would cruise for {max(cruise, 0.0):.3g} s of the "
            f"{SHORTEST:g} s needed, from {room[0]:g} to {room[1]:g} rad, within {longest:g} s. "
            "Try a slower sweep, a wider range or a longer time"
        )
    one = _Pass(0.0, velocity, build_up, hold, cruise)
    begin = min(max(pose[joint] - one.travel / 2, room[0]), room[1] - one.travel)
    return one._replace(begin=max(float(begin), room[0]))


def _chosen(limits: Limits, room: tuple[float, float], joint: int, tick: float) -> np.ndarray:
    """Velocities for a joint that has a room to sweep, shape (k,) [rad/s]."""
    full = min(limits.velocity[joint], -limits.velocity_lower[joint])
    candidates = full * np.geomspace(FASTEST, SLOWEST, 100)
    travel = [_Pass(0.0, v, *_speed_up(limits, joint, v, tick), CRUISE).travel for v in candidates]
    fits = candidates[np.array(travel) <= room[1] - room[0]]
    if len(fits) == 0:
        raise Infeasible(
            f"joint {joint + 1}: from {room[0]:g} to {room[1]:g} rad there is no room to cruise for "
            f"{CRUISE:g} s at even {candidates[-1]:.3g} rad/s. Try a wider range, or give slower velocities"
        )
    return np.geomspace(candidates[-1], fits[0], SPEEDS)


def _speeds(velocities: np.ndarray | None, joints: int) -> np.ndarray | None:
    """Velocities of each joint, shape (joints, k) [rad/s]."""
    if velocities is None:
        return None
    found = np.asarray(velocities, float)
    if found.ndim == 1:
        found = np.tile(found, (joints, 1))
    if found.ndim != 2 or len(found) != joints or found.size == 0:
        raise BadLimits(f"velocities of shape {np.shape(velocities)}; expected (k,) or ({joints}, k)")
    return found


def _joined(
    pose: np.ndarray, joint: int, passes: Iterable[_Pass], limits: Limits, tick: float, rest: float
) -> list[Trajectory]:
    """Passes of one joint from rest at a pose to rest at the same pose; it stays in its clear range."""
    parts: list[Trajectory] = []
    at = pose
    for one in passes:
        begin, end = pose.copy(), pose.copy()
        begin[joint], end[joint] = one.begin, one.begin + one.travel
        parts += [way(at, begin, limits, tick), pause(begin, rest, tick), one.phases(pose, joint, True)]
        parts += [pause(end, rest, tick), one.phases(pose, joint, False)]
        at = begin
    return [*parts, way(at, pose, limits, tick)]
