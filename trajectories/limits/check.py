"""Check that a trajectory keeps to every limit, between samples too, and can be stopped at every sample."""

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
"""Refinement of the samples beside a peak; what remains hidden between them falls with its square."""
PROMISING = 0.5
"""Share of its second difference by which a peak may exceed a sample; a parabola exceeds it by an eighth."""
LEVEL = 1e-9
"""Relative difference of torques that is rounding: on a plateau one sample represents all."""


def torque_peaks(trajectory: Trajectory, torque: Callable[[States], np.ndarray], spacing: float) -> Range:
    """Largest and smallest torque, refined around every sample nearby which a larger one is possible.

    A peak elsewhere would need four times the curvature of the samples around it. Between the finest samples
    a peak may be higher by an eighth of their largest second difference.

    Args:
        trajectory: Any trajectory of nonzero duration.
        torque: Function from states to torque of shape (t, n) [N m], without memory between samples.
        spacing: Largest spacing of the first samples [s].
    """
    count = max(int(np.ceil(trajectory.duration / spacing - 1e-6)), 2)
    time, step = np.linspace(0.0, trajectory.duration, count + 1, retstep=True)
    coarse = _both_signs(torque(trajectory.at(time)))
    centers = np.clip(time[_worth_a_look(coarse)], step, trajectory.duration - step)
    nearby = centers[:, None] + step * np.linspace(-1.0, 1.0, 2 * FINER + 1)
    nearby = np.clip(nearby, 0.0, trajectory.duration)  # rounding
    fine = _both_signs(torque(trajectory.at(nearby.ravel()))).reshape(*nearby.shape, -1)
    values = _vertices(fine).reshape(-1, fine.shape[-1])
    best = np.argmax(values, axis=0)
    highest, when = values[best, np.arange(len(best))], nearby.ravel()[best]
    (upper, lower), (upper_time, lower_time) = np.split(highest, 2), np.split(when, 2)
    return Range(-lower, upper, lower_time, upper_time)


def _both_signs(torque: np.ndarray) -> np.ndarray:
    """Torque and its negative side by side, so that every extreme is a maximum; (t, n) to (t, 2 n)."""
    return np.concatenate([torque, -torque], axis=1)


def _worth_a_look(values: np.ndarray) -> np.ndarray:
    """Rows near which some column may be larger than its largest sample."""
    bend = np.pad(np.abs(np.diff(values, 2, axis=0)), ((1, 1), (0, 0)), mode="edge")
    highest = values.max(axis=0)
    hopeful = values + PROMISING * bend > highest + LEVEL * np.abs(highest)
    hopeful[np.argmax(values, axis=0), np.arange(values.shape[1])] = True
    return np.flatnonzero(np.any(hopeful, axis=1))


def _vertices(values: np.ndarray) -> np.ndarray:
    """Samples of shape (m, samples, columns), each peak raised to the vertex of its parabola."""
    before, here, after = values[:, :-2], values[:, 1:-1], values[:, 2:]
    bend = 2 * here - before - after
    peak = (here >= before) & (here >= after) & (bend > 0.0)
    raised = values.copy()
    raised[:, 1:-1] += np.where(peak, (after - before) ** 2 / (8 * np.where(peak, bend, 1.0)), 0.0)
    return raised


ROUNDING = 1e-9
"""Share of a limit (or of the range, for a position) by which it may be exceeded through rounding."""
VIOLATED = (*UNITS, "stop", "torque")
"""Kinds of violation, besides `not finite`."""


class Violation(NamedTuple):
    """The worst violation of one limit of one joint."""

    kind: str  # one of `VIOLATED`, or `not finite` if a state or torque is NaN or infinite
    joint: int  # index of the joint, from 0
    time: float  # time of the violation; for a stop, the time at which it begins [s]
    value: float  # value that is reached, in SI units
    limit: float  # allowed value, with its sign; NaN for `not finite`

    def sentence(self, joints: Sequence[str], sliding: Collection[int] = ()) -> str:
        """The violation as a sentence; `sliding` are the prismatic joints."""
        name = joints[self.joint]
        if self.kind not in VIOLATED:
            return f"{name}: {self.kind} at {self.time:.3f} s: {self.value:g}"
        quantity = "position" if self.kind == "stop" else self.kind
        unit = unit_of(quantity, "m" if self.joint in sliding else "rad")
        subject = "a stop begun" if self.kind == "stop" else self.kind
        verb = "reaches" if self.kind == "stop" else "is"
        return (
            f"{name}: {subject} at {self.time:.3f} s {verb} {self.value:.6g}, limit {self.limit:.6g} {unit}"
        )


def check(
    trajectory: Trajectory, limits: Limits, tick: float, torque: Callable[[States], np.ndarray] | None = None
) -> list[Violation]:
    """Every violated limit, at most once for each joint and side; empty if there is none.

    Position, velocity, acceleration and jerk are checked by their exact extremes. Stops are checked at every
    sample by the closed form and, if that finds no violation, also by Ruckig: 20 000 samples take a tenth of
    a second. Torque is checked by `torque_peaks`, which states what could be missed.

    Args:
        trajectory: A trajectory of any family.
        limits: Limits to check, with finite jerk.
        tick: Sampling period of the controller [s].
        torque: Function from states to torque of shape (t, n) [N m]; without it torque is not checked.

    Raises:
        BadLimits: The number of joints differs, no joint can move within the limits, or the sampling period
            is invalid.
    """
    if trajectory.dof != len(limits.velocity) or not 0.0 < tick < np.inf:
        raise BadLimits(
            f"a trajectory of {trajectory.dof} joints, limits of {len(limits.velocity)}, and a sampling "
            f"period of {tick:g} s; the numbers of joints must agree, and the sampling period be above 0"
        )
    states = trajectory.every(tick)
    violations = list(_not_finite(states))
    if violations:
        return violations
    for (quantity, bounds), reached in zip(ranges(limits).items(), trajectory.extremes(), strict=True):
        violations += beyond(quantity, reached, *bounds)
    violations += _beyond_stops(states, limits)
    if torque is not None and np.any(np.isfinite(limits.torque)):
        peaks = torque_peaks(trajectory, torque, tick)
        violations += beyond("torque", peaks, -limits.torque, limits.torque)
    return violations


def _not_finite(states: States) -> Iterable[Violation]:
    """The first state of each joint that is not finite."""
    wrong = ~np.isfinite(np.stack(states[1:]))
    for joint in np.flatnonzero(np.any(wrong, axis=(0, 1))):
        row = int(np.argmax(np.any(wrong[:, :, joint], axis=0)))
        kind = int(np.argmax(wrong[:, row, joint]))
        value = float(states[1 + kind][row, joint])
        yield Violation("not finite", int(joint), float(states.time[row]), value, np.nan)


def _beyond_stops(states: States, limits: Limits) -> list[Violation]:
    """Stops that leave the position limits, by either of the two computations."""
    time = np.broadcast_to(states.time[:, None], states.position.shape)
    violations: list[Violation] = []
    for reach_of in (stopping_reach, brake_reach):
        if not violations:
            reach = reach_of(states.velocity, states.acceleration, limits)
            down, up = states.position + reach.lower, states.position + reach.upper
            reached = lowest_and_highest(down, up, time, time)
            violations = beyond("stop", reached, *ranges(limits)["position"])
    return violations


def beyond(kind: str, reached: Range, lower: np.ndarray, upper: np.ndarray) -> list[Violation]:
    """Violations where a range exceeds its limits, shape (n,)."""
    room = np.where(np.isfinite(upper - lower), upper - lower, 1.0) if kind in ("position", "stop") else None
    violations = []
    sides = (
        (reached.lower, reached.lower_time, lower, -1.0),
        (reached.upper, reached.upper_time, upper, 1.0),
    )
    for value, time, limit, side in sides:
        slack = ROUNDING * (np.where(np.isfinite(limit), np.abs(limit), 0.0) if room is None else room)
        for joint in np.flatnonzero(~(side * value <= side * limit + slack)):
            finite = np.isfinite(value[joint])
            allowed = float(limit[joint]) if finite else np.nan
            name = kind if finite else "not finite"
            violations.append(Violation(name, int(joint), float(time[joint]), float(value[joint]), allowed))
    return violations
