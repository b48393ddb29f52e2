"""Check: whether a trajectory keeps to every limit, between samples too, and can be stopped on every tick."""

from collections.abc import Callable, Collection, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from exidyn.identify.arm.robot import Limits

from ..errors import BadLimits
from ..trajectory import UNITS, Range, States, Trajectory, lowest_and_highest, unit_of
from .brake import stopping_reach
from .moves import brake_reach
from .torque_peaks import torque_peaks
from .usable_limits import ranges

ROUNDING = 1e-9
"""Share of a limit (of the range, for a position) by which passing it is rounding."""
VIOLATED = (*UNITS, "stop", "torque")
"""What can be violated, beside `no number`."""


class Violation(NamedTuple):
    """One limit of one joint that is not kept, where it is worst.

    Attributes:
        what: One of `VIOLATED`, or `no number` where a state or torque is NaN or infinite.
        joint: Which joint, from 0.
        time: When; of a stop, when it begins [s].
        value: What is reached, in SI units.
        limit: What is allowed, with its sign; NaN for `no number`.
    """

    what: str
    joint: int
    time: float
    value: float
    limit: float

    def sentence(self, joints: Sequence[str], sliding: Collection[int] = ()) -> str:
        """The same in words; `sliding` are the prismatic joints."""
        name = joints[self.joint]
        if self.what not in VIOLATED:
            return f"{name}: {self.what} at {self.time:.3f} s, but {self.value:g}"
        quantity = "position" if self.what == "stop" else self.what
        unit = unit_of(quantity, "m" if self.joint in sliding else "rad")
        what = "a stop begun" if self.what == "stop" else self.what
        reaches = "reaches" if self.what == "stop" else "is"
        return (
            f"{name}: {what} at {self.time:.3f} s {reaches} {self.value:.6g}, limit {self.limit:.6g} {unit}"
        )


def check(
    trajectory: Trajectory,
    limits: Limits,
    tick: float,
    torque: Callable[[States], np.ndarray] | None = None,
) -> list[Violation]:
    """Every limit that is not kept, at most once for each joint and side; empty if all are.

    Position, velocity, acceleration and jerk by their exact extremes. Stops begun on every tick, by the
    closed form and, where it finds none that goes too far, by Ruckig too, at all ticks: 20 000 cost a
    tenth of a second. Torque as in `torque_peaks`, which states what could be missed.

    Args:
        trajectory: Of any family.
        limits: What it must keep to; the jerk finite.
        tick: Cycle of the controller [s].
        torque: Shape (t, n) [N m] for given states; without it torque is not looked at.

    Raises:
        BadLimits: Limits of another number of joints, or within which no joint can move; no tick.
    """
    if trajectory.dof != len(limits.velocity) or not 0.0 < tick < np.inf:
        raise BadLimits(
            f"a trajectory of {trajectory.dof} joints, limits of {len(limits.velocity)}, a tick of "
            f"{tick:g} s; the joints must be the same, and the tick above 0"
        )
    states = trajectory.every(tick)
    found = list(_not_numbers(states))
    if found:
        return found
    for (what, bounds), reached in zip(ranges(limits).items(), trajectory.extremes(), strict=True):
        found += _beyond(what, reached, *bounds)
    found += _beyond_stops(states, limits)
    if torque is not None and np.any(np.isfinite(limits.torque)):
        peaks = torque_peaks(trajectory, torque, tick)
        found += _beyond("torque", Range(*peaks[:4]), -limits.torque, limits.torque)
    return found


def _not_numbers(states: States) -> Iterable[Violation]:
    """The first state of each joint that is not finite."""
    wrong = ~np.isfinite(np.stack(states[1:]))
    for joint in np.flatnonzero(np.any(wrong, axis=(0, 1))):
        row = int(np.argmax(np.any(wrong[:, :, joint], axis=0)))
        kind = int(np.argmax(wrong[:, row, joint]))
        value = float(states[1 + kind][row, joint])
        yield Violation("no number", int(joint), float(states.time[row]), value, np.nan)


def _beyond_stops(states: States, limits: Limits) -> list[Violation]:
    """Stops that leave the position limits, by either of the two computations."""
    time = np.broadcast_to(states.time[:, None], states.position.shape)
    found: list[Violation] = []
    for reach_of in (stopping_reach, brake_reach):
        if not found:
            reach = reach_of(states.velocity, states.acceleration, limits)
            down, up = states.position + reach.lower, states.position + reach.upper
            found = _beyond("stop", lowest_and_highest(down, up, time, time), *ranges(limits)["position"])
    return found


def _beyond(what: str, reached: Range, lower: np.ndarray, upper: np.ndarray) -> list[Violation]:
    """Where a range leaves its limits, shape (n,)."""
    room = np.where(np.isfinite(upper - lower), upper - lower, 1.0) if what in ("position", "stop") else None
    found = []
    sides = (
        (reached.lower, reached.lower_time, lower, -1.0),
        (reached.upper, reached.upper_time, upper, 1.0),
    )
    for value, time, limit, side in sides:
        slack = ROUNDING * (np.where(np.isfinite(limit), np.abs(limit), 0.0) if room is None else room)
        for joint in np.flatnonzero(~(side * value <= side * limit + slack)):
            number = np.isfinite(value[joint])
            allowed = float(limit[joint]) if number else np.nan
            kind = what if number else "no number"
            found.append(Violation(kind, int(joint), float(time[joint]), float(value[joint]), allowed))
    return found
