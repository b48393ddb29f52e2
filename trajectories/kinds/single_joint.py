r"""Single-joint runs: each joint in turn moves alone, fast and then slowly, while the others rest.

These runs exclude coupling. If a joint's model explains its single-joint run but not the motion of all
joints, the coupling is wrong. If it fails on the single-joint run, the joint's drive is wrong.
"""

from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..errors import Infeasible
from ..families.fourier import Fourier
from ..families.sequence import Sequence
from ..limits.brake import stoppable
from ..limits.usable_limits import ranges
from ..trajectory import Trajectory, whole_ticks
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
"""Rest between two motions [s]."""
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
        clear = _within(space.limits, joint, *space.clear_range(pose, joint))
        fast = _fastest(_wave(clear, pose, joint), clear, space.tick)
        slow = replace(fast, period=whole_ticks(SLOW_DOWN * fast.period, space.tick), periods=1)
        still = space.pause(pose, REST)
        parts += [still, fast, still, slow]
    parts.append(space.pause(pose, REST))
    return joined(parts)


def _within(limits: Limits, joint: int, lower: float, upper: float) -> Limits:
    """Limits with a narrower range of one joint, so that its stops also end inside the clear range."""
    narrow_lower, narrow_upper = limits.position_lower.copy(), limits.position_upper.copy()
    narrow_lower[joint], narrow_upper[joint] = lower, upper
    return replace(limits, position_lower=narrow_lower, position_upper=narrow_upper)


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
