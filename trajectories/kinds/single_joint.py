r"""Single-joint runs: each joint in turn moves alone, fast and then slowly, while the others rest.

What couples joints is out of the equation: a run that one joint's model explains alone, and the whole
arm's motion does not, points at coupling, and a joint that fails by itself at its drive.
"""

from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..errors import BadLimits, Infeasible
from ..families.fourier import Fourier
from ..families.sequence import Sequence
from ..limits.brake import stoppable
from ..limits.usable_limits import ranges
from ..trajectory import Trajectory, whole_ticks
from .rests import clear_range, pause, require_joints, require_limits, require_pose

FAST = 5
"""The faster of the two harmonics: half as many reversals of the joint, at places that differ."""
WIDEST = 1.0
"""Largest excursion either way [rad]: gravity changes by most of what it can."""
ROOM = 0.8
"""Share of the way to the nearer limit that is used; the rest is to stop in."""
NARROWEST = 0.02
"""Least excursion [rad]: some times the 8 mrad over which friction builds up after a reversal."""
SLOW_DOWN = 4.0
"""How much slower the second time: a sixteenth of the acceleration leaves gravity and friction alone."""
PERIODS = 2
"""Of the fast part, to distinguish what repeats from noise; the slow one is long enough for one."""
REST = 0.5
"""Rest between two motions [s]."""
LONGER = 1.1
"""Factor by which a period grows until every stop ends inside the limits."""


def single_joint_runs(
    limits: Limits,
    joints: Collection[int],
    pose: np.ndarray,
    tick: float,
    share: float = 0.9,
    widest: float = WIDEST,
    periods: int = PERIODS,
    rest: float = REST,
    clearances: Collection[Clearance] = (),
    begin: Callable[[int], None] = lambda joint: None,
) -> Sequence:
    r"""Each joint by itself along :math:`\sin \omega t - \sin(5 \omega t) / 5`, fast and slow.

    At both ends of a period position, velocity and acceleration are zero, so that it needs no lead.

    Args:
        limits: Finite but for the torque.
        joints: Which move, counted from 0, in this order.
        pose: Where all others rest, and each begins and ends, shape (n,) [rad].
        tick: Cycle of the controller [s].
        share: Share of the velocity, acceleration and jerk limits that the fast part may use [-].
        widest: Largest excursion either way [rad].
        periods: Periods of the fast part; the slow one has one.
        rest: Before each part, and at the end [s].
        clearances: What to keep clear of; a joint's excursion shrinks to what is.
        begin: Called with each joint before its motions are made.

    Raises:
        BadLimits: Limits or joints that are none.
        Infeasible: A pose outside the limits or not clear, or a joint without room to move.
    """
    require_limits(limits, tick)
    require_joints(joints, limits)
    pose = require_pose(pose, limits)
    if not 0.0 < share <= 1.0:
        raise BadLimits(f"a share of {share:g} of the limits; it must be above 0 and at most 1")
    parts: list[Trajectory] = []
    for joint in joints:
        begin(joint)
        clear = _within(limits, joint, *clear_range(limits, pose, joint, clearances))
        fast = _fastest(_wave(clear, pose, joint, widest, periods), clear, share, tick)
        slow = replace(fast, period=whole_ticks(SLOW_DOWN * fast.period, tick), periods=1)
        still = pause(pose, rest, tick)
        parts += [still, fast, still, slow]
    parts.append(pause(pose, rest, tick))
    return Sequence(tuple(part for part in parts if part.duration > 0.0))


def _within(limits: Limits, joint: int, lower: float, upper: float) -> Limits:
    """Limits with a narrower range of one joint, so that its stops, too, end where it is clear."""
    narrow = [limits.position_lower.copy(), limits.position_upper.copy()]
    narrow[0][joint], narrow[1][joint] = lower, upper
    return replace(limits, position_lower=narrow[0], position_upper=narrow[1])


def _wave(limits: Limits, pose: np.ndarray, joint: int, widest: float, periods: int) -> Fourier:
    """One joint's motion about a pose, as wide as there is room for, of a period of one second."""
    lower, upper = limits.position_lower[joint], limits.position_upper[joint]
    excursion = float(np.min([ROOM * (pose[joint] - lower), ROOM * (upper - pose[joint]), widest]))
    if not excursion >= NARROWEST:
        raise Infeasible(
            f"joint {joint + 1}: at {pose[joint]:g} rad it can swing by {excursion:.3g} rad either way "
            f"between {lower:g} and {upper:g}, and needs {NARROWEST:g}. Try a pose with more room around it"
        )
    sine = np.zeros((len(pose), FAST))
    sine[joint, [0, FAST - 1]] = 1.0, -1.0 / FAST
    shape = Fourier(1.0, pose, sine, np.zeros_like(sine), periods)
    return shape.scaled(excursion / (shape.extremes().position.upper[joint] - pose[joint]))


def _fastest(wave: Fourier, limits: Limits, share: float, tick: float) -> Fourier:
    """The same with the shortest period, in ticks, that keeps to a share of all limits and can be stopped."""
    uses = list(zip(wave.extremes(), ranges(limits).values(), strict=True))[1:]
    needed = [
        np.max(np.maximum(reached.upper / upper, reached.lower / lower) / share) ** (1 / order)
        for order, (reached, (lower, upper)) in enumerate(uses, start=1)
    ]
    found = replace(wave, period=whole_ticks(max(needed), tick))
    while not np.all(stoppable(found.every(tick), limits)):
        found = replace(found, period=whole_ticks(LONGER * found.period, tick))
    return found
