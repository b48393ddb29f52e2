"""Check: whether a trajectory keeps to every limit, between samples too, and can be stopped on every tick."""

from collections.abc import Callable, Collection, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..errors import BadLimits
from ..trajectory import UNITS, Range, States, Trajectory, lowest_and_highest, unit_of
from .brake import stopping_reach
from .moves import brake_reach
from .usable_limits import ranges

FINER = 16
"""Into how many parts the samples beside a peak are divided; what hides between falls with its square."""
PROMISING = 0.5
"""Share of its second difference that a sample is trusted to hide; a parabola hides an eighth."""
LEVEL = 1e-9
"""Relative difference of torques that is rounding: on a plateau one sample stands for all."""


class TorquePeaks(NamedTuple):
    """Extremes of each joint's torque, each of shape (n,).

    Attributes:
        lower: [N m].
        upper: [N m].
        lower_time: [s].
        upper_time: [s].
        hidden: What may hide between the finest samples if the torque bends no more than they show: an
            eighth of their largest second difference [N m].
    """

    lower: np.ndarray
    upper: np.ndarray
    lower_time: np.ndarray
    upper_time: np.ndarray
    hidden: np.ndarray


def torque_peaks(
    trajectory: Trajectory, torque: Callable[[States], np.ndarray], spacing: float
) -> TorquePeaks:
    """Largest and smallest torque, refined around every sample that could hide a larger one.

    A peak elsewhere would have to bend four times as much as the samples around it do.

    Args:
        trajectory: Anything longer than no time.
        torque: Shape (t, n) [N m] for given states; each sample on its own, without memory.
        spacing: Spacing of the first samples, at most [s].
    """
    count = max(int(np.ceil(trajectory.duration / spacing - 1e-6)), 2)
    time, step = np.linspace(0.0, trajectory.duration, count + 1, retstep=True)
    coarse = _both_signs(torque(trajectory.at(time)))
    centres = np.clip(time[_worth_a_look(coarse)], step, trajectory.duration - step)
    near = centres[:, None] + step * np.linspace(-1.0, 1.0, 2 * FINER + 1)
    near = np.clip(near, 0.0, trajectory.duration)  # rounding
    fine = _both_signs(torque(trajectory.at(near.ravel()))).reshape(*near.shape, -1)
    bend = np.abs(np.diff(fine, 2, axis=1)) / 8
    values = _vertices(fine).reshape(-1, fine.shape[-1])
    best = np.argmax(values, axis=0)
    highest, when = values[best, np.arange(len(best))], near.ravel()[best]
    (upper, lower), (upper_time, lower_time) = np.split(highest, 2), np.split(when, 2)
    hidden = np.max(np.split(bend.max(axis=(0, 1)), 2), axis=0)
    return TorquePeaks(-lower, upper, lower_time, upper_time, hidden)


def _both_signs(torque: np.ndarray) -> np.ndarray:
    """Torque and its negative side by side, so that every extreme is a maximum; (t, n) to (t, 2 n)."""
    return np.concatenate([torque, -torque], axis=1)


def _worth_a_look(values: np.ndarray) -> np.ndarray:
    """Rows at which some column may be larger than its largest sample."""
    bend = np.pad(np.abs(np.diff(values, 2, axis=0)), ((1, 1), (0, 0)), mode="edge")
    highest = values.max(axis=0)
    hopeful = values + PROMISING * bend > highest + LEVEL * np.abs(highest)
    hopeful[np.argmax(values, axis=0), np.arange(values.shape[1])] = True
    return np.flatnonzero(np.any(hopeful, axis=1))


def _vertices(values: np.ndarray) -> np.ndarray:
    """Samples (m, samples, columns), each peak among them raised to the top of its parabola."""
    before, here, after = values[:, :-2], values[:, 1:-1], values[:, 2:]
    bend = 2 * here - before - after
    peak = (here >= before) & (here >= after) & (bend > 0.0)
    raised = values.copy()
    raised[:, 1:-1] += np.where(peak, (after - before) ** 2 / (8 * np.where(peak, bend, 1.0)), 0.0)
    return raised


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
        trajectory: Any family.
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
