"""Runs of one joint at a time, fast and then slowly, or at constant velocities, while the others rest.

These runs exclude coupling. If a joint's model explains its single-joint run but not the motion of all
joints, the coupling is wrong. If it fails on the single-joint run, the joint's drive is wrong. Slow sweeps
at constant velocity give the friction curve of a joint, and how it depends on load.
"""

from collections.abc import Callable, Collection, Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..errors import Infeasible
from ..families.fourier import Fourier
from ..families.phases import Phases
from ..families.sequence import Sequence
from ..limits.brake import stoppable
from ..limits.usable_limits import ranges
from ..trajectory import PART_OF_TICK, State, Trajectory, whole_ticks
from .rests import Workspace, joined

FAST = 5
"""The faster of the two harmonics: half as many reversals of the joint, at different positions."""
WIDEST = 1.0
"""Largest excursion either way [rad]: gravity changes by most of its range."""
SHARE = 0.9
"""Share of the velocity, acceleration and jerk limits that the fast part may use [-]."""
ROOM = 0.8
"""Share of the distance to the nearer limit that the excursion uses; the remainder is for stopping."""
NARROWEST = 0.02
"""Least excursion [rad]: a multiple of the 8 mrad over which friction builds up after a reversal."""
SLOW_DOWN = 4.0
"""Ratio of the slow to the fast period: at a sixteenth of the acceleration, gravity and friction dominate."""
PERIODS = 2
"""Periods of the fast part, to tell repeating torque from noise; the slow part is long enough with one."""
REST = 0.5
"""Rest between two motions [s]: long enough for vibrations after a stop to die out."""
LONGER = 1.1
"""Factor by which a period grows until every stop ends inside the limits."""


def single_joint_runs(
    space: Workspace,
    joints: Collection[int],
    pose: np.ndarray,
    begin: Callable[[int], None] = lambda joint: None,
) -> Sequence:
    r"""Each joint by itself along :math:`\sin \omega t - \sin(5 \omega t) / 5`, fast and slow.

    Position, velocity and acceleration are zero at both ends of a period, so no lead is needed.

    Each joint begins and ends at the pose (n,) [rad], where the others rest; its excursion shrinks to its
    clear range.

    Raises:
        Infeasible: The pose is not clear, or a joint has no room to move.
    """
    parts: list[Trajectory] = []
    for joint in joints:
        begin(joint)
        clear = _within(space.limits, joint, space.clear_range(pose, joint))
        fast = _fastest(_wave(clear, pose, joint), clear, space.tick)
        slow = replace(fast, period=whole_ticks(SLOW_DOWN * fast.period, space.tick), periods=1)
        still = space.pause(pose, REST)
        parts += [still, fast, still, slow]
    parts.append(space.pause(pose, REST))
    return joined(parts)


def _within(limits: Limits, joint: int, room: tuple[float, float]) -> Limits:
    """Limits with a narrower range of one joint, so that its stops also end inside the clear range."""
    lower, upper = limits.position_lower.copy(), limits.position_upper.copy()
    lower[joint], upper[joint] = room
    return replace(limits, position_lower=lower, position_upper=upper)


def _wave(limits: Limits, pose: np.ndarray, joint: int) -> Fourier:
    """One joint's motion about a pose, as wide as its range allows, with a period of one second."""
    lower, upper = limits.position_lower[joint], limits.position_upper[joint]
    excursion = float(np.min([ROOM * (pose[joint] - lower), ROOM * (upper - pose[joint]), WIDEST]))
    if not excursion >= NARROWEST:
        raise Infeasible(
            f"joint {joint + 1}: at {pose[joint]:g} rad its excursion is at most {excursion:.3g} rad either "
            f"way, between {lower:g} and {upper:g}; at least {NARROWEST:g} is needed. "
            "Try a pose with more room around it"
        )
    sine = np.zeros((len(pose), FAST))
    sine[joint, [0, FAST - 1]] = 1.0, -1.0 / FAST
    shape = Fourier(1.0, pose, sine, np.zeros_like(sine), PERIODS)
    return shape.scaled(excursion / (shape.extremes().position.upper[joint] - pose[joint]))


def _fastest(wave: Fourier, limits: Limits, tick: float) -> Fourier:
    """The wave, stoppable and as fast as `SHARE` of all limits allows, in whole sampling periods."""
    used = list(zip(wave.extremes(), ranges(limits).values(), strict=True))[1:]
    needed = [
        np.max(np.maximum(reached.upper / upper, reached.lower / lower) / SHARE) ** (1 / order)
        for order, (reached, (lower, upper)) in enumerate(used, start=1)
    ]
    fastest = replace(wave, period=whole_ticks(max(needed), tick))
    while not np.all(stoppable(fastest.every(tick), limits)):
        fastest = replace(fastest, period=whole_ticks(LONGER * fastest.period, tick))
    return fastest


SLOWEST, FASTEST = 0.01, 0.6
"""Shares of the velocity limit. A hundredth, about 0.02 rad/s, is below the Stribeck velocity (0.1 rad/s,
within a factor of five), where boundary friction dominates. At six tenths the lubricant film carries the
load, and half of the range remains for the cruise."""
SPEEDS = 6
"""Number of speeds, evenly spaced in the logarithm: two or three on either side of the Stribeck velocity."""
CRUISE = 1.0
"""Least cruise [s]: 20 periods of a 20 Hz low-pass to average over."""
LONGEST = 10.0
"""Longest cruise [s]: at 0.02 rad/s and a gear ratio of 100, three motor turns, and so three periods of a
ripple with one period per turn."""


def constant_velocity_sweeps(
    space: Workspace,
    joints: Collection[int],
    pose: np.ndarray,
    begin: Callable[[int], None] = lambda joint: None,
) -> Sequence:
    """Sweep joints in turn, forward and backward, at six velocities, from rest to rest at a pose.

    Friction is half the difference of the forward and backward torques at the same position, where gravity
    is equal. The velocities of a joint go from a hundredth to six tenths of its limit, or to less if its
    range is too short to cruise for a second.

    The other joints rest at the pose (n,) [rad]; ranges shrink to what is clear.

    Raises:
        Infeasible: The pose is not clear, or a joint has no room to cruise.
    """
    parts: list[Trajectory] = []
    for joint in joints:
        begin(joint)
        room = space.clear_range(pose, joint)
        passes = [_pass(space, room, pose, joint, v) for v in _speeds(space, room, joint)]
        parts += _joined(space, pose, joint, passes)
    return joined(parts)


class _Pass(NamedTuple):
    """One pass of a sweep: speed up, cruise, slow down, each in whole sampling periods."""

    begin: float  # position of the joint at rest before the forward pass [rad]
    velocity: float  # velocity of the cruise, above zero [rad/s]
    build_up: float  # time in which the acceleration rises or falls [s]
    hold: float  # time for which the acceleration is held [s]
    cruise: float  # duration of the cruise [s]

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


def _speed_up(space: Workspace, joint: int, velocity: float) -> tuple[float, float]:
    """Times to build up and to hold the acceleration, such that every switch falls on a sample [s].

    This is not the fastest speed-up: one that ended between two samples would spoil a sample of the cruise,
    and Ruckig swings back first if it must end on a sample after a fixed distance.
    """
    limits, tick = space.limits, space.tick
    most = min(limits.acceleration[joint], -limits.acceleration_lower[joint])
    jerk = float(limits.jerk[joint])
    build_up = whole_ticks(min(most / jerk, np.sqrt(velocity / jerk)), tick)
    total = whole_ticks(max(velocity / most, velocity / (jerk * build_up), build_up), tick)
    return build_up, total - build_up


def _pass(
    space: Workspace, room: tuple[float, float], pose: np.ndarray, joint: int, velocity: float
) -> _Pass:
    """A pass within the range `room`, centered on the pose as far as the range allows."""
    build_up, hold = _speed_up(space, joint, velocity)
    available = (room[1] - room[0]) / velocity - (2 * build_up + hold)
    cruise = float(np.floor(min(available, LONGEST) / space.tick + PART_OF_TICK) * space.tick)
    sweep = _Pass(0.0, velocity, build_up, hold, cruise)
    begin = min(max(pose[joint] - sweep.travel / 2, room[0]), room[1] - sweep.travel)
    return sweep._replace(begin=max(float(begin), room[0]))


def _speeds(space: Workspace, room: tuple[float, float], joint: int) -> list[float]:
    """Velocities at which a joint can sweep the range `room` [rad/s]; raises `Infeasible` without any."""
    full = min(space.limits.velocity[joint], -space.limits.velocity_lower[joint])
    candidates = full * np.geomspace(FASTEST, SLOWEST, 100)
    travel = [_Pass(0.0, v, *_speed_up(space, joint, v), CRUISE).travel for v in candidates]
    fits = candidates[np.array(travel) <= room[1] - room[0]]
    if len(fits) == 0:
        raise Infeasible(
            f"joint {joint + 1}: from {room[0]:g} to {room[1]:g} rad there is no room to cruise for "
            f"{CRUISE:g} s, even at {candidates[-1]:.3g} rad/s. Try a pose with more room around it"
        )
    return [float(speed) for speed in np.geomspace(candidates[-1], fits[0], SPEEDS)]


def _joined(space: Workspace, pose: np.ndarray, joint: int, passes: Iterable[_Pass]) -> list[Trajectory]:
    """Passes of one joint from rest to rest at a pose; the joint stays in its clear range."""
    parts, at = list[Trajectory](), pose
    for sweep in passes:
        begin, end = pose.copy(), pose.copy()
        begin[joint], end[joint] = sweep.begin, sweep.begin + sweep.travel
        parts += [space.move(at, begin), space.pause(begin, REST), sweep.phases(pose, joint, True)]
        parts += [space.pause(end, REST), sweep.phases(pose, joint, False)]
        at = begin
    return [*parts, space.move(at, pose)]
