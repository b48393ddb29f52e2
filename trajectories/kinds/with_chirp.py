"""A chirp as large as the limits leave room for, on top of a motion."""

from collections.abc import Collection
from typing import Any

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..errors import BadLimits, Infeasible
from ..families.chirp import Chirp
from ..limits.brake import stoppable
from ..limits.usable_limits import ranges
from ..trajectory import Trajectory
from .rests import require_clear, require_joints, require_limits

LOW = 1.0
"""Where a chirp starts [Hz]: half an octave above what identification runs are made of."""
HIGH = 20.0
"""Where it ends [Hz], if the tick allows: arms' first resonances are at 5 to 20 Hz, and the usual filter of
the measurement ends there."""
LEAST = 4.0
"""Of the highest frequency over the lowest: two octaves, below which a chirp shows no slope of anything."""
SAMPLES = 6
"""Least samples a period, a third of Nyquist's frequency: a controller that joins them by straight lines
still moves by 91 % of the amplitude."""
SHARE = 0.5
"""Of the room that the motion under it leaves: a joint at its resonance swings further than commanded."""
RESOLUTION = 1e-6
"""What an encoder before a gear of 100 resolves [rad]: 16 bit a turn of the motor."""
STEPS = 10
"""Least amplitude in steps of the encoder: quantisation is then 3 % of it."""
SMALLER = 0.8
"""Factor by which the amplitude shrinks until every stop ends inside the limits and there is no contact."""


def with_chirp(
    base: Trajectory,
    joints: Collection[int],
    limits: Limits,
    tick: float,
    low: float = LOW,
    high: float | None = None,
    share: float = SHARE,
    logarithmic: bool = True,
    resolution: float = RESOLUTION,
    clearances: Collection[Clearance] = (),
) -> Chirp:
    """A motion with a chirp from its beginning to its end; at both ends the chirp adds nothing.

    Args:
        base: Such as rest at a pose, `Phases.hold`. Ten seconds are well spent.
        joints: Which have the chirp, counted from 0.
        limits: Finite but for the torque.
        tick: Cycle of the controller [s].
        low: Frequency at the start [Hz].
        high: Frequency at the end [Hz]; unless given 20 Hz, or less where a period would have under six
            ticks or the limits would leave too little to measure.
        share: Share of what `base` leaves of each limit [-].
        logarithmic: Whether the frequency doubles in equal times, as many periods near each frequency.
        resolution: What the joints' encoders resolve [rad].
        clearances: What to keep clear of; the amplitude shrinks until it is.

    Raises:
        BadLimits: Limits, joints, frequencies or a share that are none.
        Infeasible: The motion leaves no room, collides or is not stoppable itself, or the amplitude
            cannot be measured.
    """
    require_limits(limits, tick)
    require_joints(joints, limits)
    require_clear("the motion under the chirp", base, clearances)
    highest = 1.0 / (SAMPLES * tick)
    if high is None:
        rest = share, logarithmic, resolution, clearances
        return _highest(base, joints, limits, tick, low, min(HIGH, highest), *rest)
    if not 0.0 < low < high <= highest * (1 + 1e-9):
        raise BadLimits(
            f"a chirp from {low:g} to {high:g} Hz; it must rise, and a tick of {tick:g} s allows up to "
            f"{highest:.4g} Hz, {SAMPLES} ticks a period. Try other frequencies or a shorter tick"
        )
    if not 0.0 < share <= 1.0:
        raise BadLimits(f"a share of {share:g} of the limits; it must be above 0 and at most 1")
    if not base.duration * low >= 2.0:
        raise BadLimits(
            f"a motion of {base.duration:g} s; a chirp rises and falls over a period each, together "
            f"{2 / low:g} s at {low:g} Hz. Try a longer motion"
        )
    largest = share * _room(base, tuple(joints), limits)
    # envelope, rising frequency and falling amplitude add to what a plain sine would reach
    trial = Chirp(base, tuple(joints), largest, low, high, 0.0, base.duration, 1.0 / low, logarithmic)
    chirp = trial.scaled(1.0 / max(1.0, float(np.max(trial.reached / largest))))
    return _safe(chirp, limits, tick, resolution, clearances)


def _highest(
    base: Trajectory,
    joints: Collection[int],
    limits: Limits,
    tick: float,
    low: float,
    high: float,
    *rest: Any,
) -> Chirp:
    """The chirp up to the highest frequency at which its amplitude can be measured."""
    while True:
        try:
            return with_chirp(base, joints, limits, tick, low, high, *rest)
        except Infeasible:
            high *= SMALLER
            if high < LEAST * low:
                raise


def _room(base: Trajectory, joints: tuple[int, ...], limits: Limits) -> np.ndarray:
    """What a motion leaves of position, velocity, acceleration and jerk either way, shape (k, 4)."""
    room = np.empty((len(joints), 4))
    bounds = zip(ranges(limits).items(), base.extremes(), strict=True)
    for order, ((name, (lower, upper)), found) in enumerate(bounds):
        left = np.minimum(upper - found.upper, found.lower - lower)
        for place, joint in enumerate(joints):
            room[place, order] = left[joint]
            if not left[joint] > 0.0:
                raise Infeasible(
                    f"joint {joint + 1}: the motion's own {name}, {found.lower[joint]:g} to "
                    f"{found.upper[joint]:g}, leaves no room for a chirp within {lower[joint]:g} to "
                    f"{upper[joint]:g}. Try a slower motion, or rest in the middle of the range"
                )
    return room


def _safe(
    chirp: Chirp, limits: Limits, tick: float, resolution: float, clearances: Collection[Clearance]
) -> Chirp:
    """The chirp, smaller if need be, such that every stop ends inside the limits and there is no contact."""
    while True:
        _require_measurable(chirp, resolution)
        clear = all(clearance.worst(chirp).allowed for clearance in clearances)
        if clear and np.all(stoppable(chirp.every(tick), limits)):
            return chirp
        chirp = chirp.scaled(SMALLER)


def _require_measurable(chirp: Chirp, resolution: float) -> None:
    frequency = np.geomspace(chirp.low, chirp.high, 100)
    steps = chirp.amplitude(frequency) / resolution
    for place, joint in enumerate(chirp.joints):
        small = steps[:, place] < STEPS
        if np.any(small):
            first = frequency[np.argmax(small)]
            raise Infeasible(
                f"joint {joint + 1}: at {chirp.high:g} Hz the limits leave an amplitude of "
                f"{steps[-1, place] * resolution:.3g} rad, {steps[-1, place]:.2g} steps of an encoder of "
                f"{resolution:g} rad; at least {STEPS} are needed, from {first:.3g} Hz on it is less. "
                "Try a lower frequency, a larger share, or a slower motion under it"
            )
