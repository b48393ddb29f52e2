"""A chirp on top of a motion, as large as the limits allow."""

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
"""Lowest frequency of a chirp [Hz]: half an octave above the frequencies of identification runs."""
HIGH = 20.0
"""Highest frequency of a chirp [Hz], if the sampling period allows: the first resonances of arms are at 5 to
20 Hz, and the usual measurement filter ends there."""
LEAST = 4.0
"""Least ratio of the highest to the lowest frequency: two octaves, below which a chirp reveals no slope."""
SAMPLES = 6
"""Least samples per period, a third of the Nyquist frequency: a controller that interpolates linearly still
moves by 91 % of the amplitude."""
SHARE = 0.5
"""Share of the room that the base motion leaves: a joint at resonance swings further than commanded."""
RESOLUTION = 1e-6
"""Resolution of an encoder before a gear with ratio 100 [rad]: 16 bit per motor turn."""
STEPS = 10
"""Least amplitude in encoder steps: quantization is then 3 % of it."""
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
    """A motion with a chirp from beginning to end; the chirp is zero at both ends.

    Args:
        base: Motion under the chirp, such as rest at a pose, `Phases.hold`; ten seconds are a good duration.
        joints: Joints with a chirp, counted from 0.
        limits: Limits, finite except for torque.
        tick: Sampling period of the controller [s].
        low: Frequency at the start [Hz].
        high: Frequency at the end [Hz]; by default 20 Hz, or less if a period would have fewer than six
            samples or the limits would leave too small an amplitude to measure.
        share: Share of the room that `base` leaves to each limit [-].
        logarithmic: Whether the frequency doubles in equal times, with as many periods near each frequency.
        resolution: Resolution of the joint encoders [rad].
        clearances: Clearances to keep; the amplitude shrinks until they are kept.

    Raises:
        BadLimits: The limits, joints, frequencies or share are invalid.
        Infeasible: The base motion leaves no room, collides or cannot be stopped, or the amplitude is too
            small to measure.
    """
    require_limits(limits, tick)
    require_joints(joints, limits)
    require_clear("the motion under the chirp", base, clearances)
    highest = 1.0 / (SAMPLES * tick)
    if high is None:
        options = share, logarithmic, resolution, clearances
        return _highest(base, joints, limits, tick, low, min(HIGH, highest), *options)
    if not 0.0 < low < high <= highest * (1 + 1e-9):
        raise BadLimits(
            f"the chirp goes from {low:g} to {high:g} Hz; it must rise, and a sampling period of {tick:g} s "
            f"allows up to {highest:.4g} Hz, {SAMPLES} samples per period. Try other frequencies or a "
            "shorter sampling period"
        )
    if not 0.0 < share <= 1.0:
        raise BadLimits(f"the share of the limits is {share:g}; it must be above 0 and at most 1")
    if not base.duration * low >= 2.0:
        raise BadLimits(
            f"the motion lasts {base.duration:g} s; a chirp rises and falls over one period each, together "
            f"{2 / low:g} s at {low:g} Hz. Try a longer motion"
        )
    largest = share * _room(base, tuple(joints), limits)
    # envelope, rising frequency and falling amplitude reach more than a plain sine
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
    *options: Any,
) -> Chirp:
    """The chirp up to the highest frequency at which its amplitude can be measured."""
    while True:
        try:
            return with_chirp(base, joints, limits, tick, low, high, *options)
        except Infeasible:
            high *= SMALLER
            if high < LEAST * low:
                raise


def _room(base: Trajectory, joints: tuple[int, ...], limits: Limits) -> np.ndarray:
    """Room of position, velocity, acceleration and jerk between a motion and its limits, shape (k, 4)."""
    room = np.empty((len(joints), 4))
    bounds = zip(ranges(limits).items(), base.extremes(), strict=True)
    for order, ((name, (lower, upper)), reached) in enumerate(bounds):
        remaining = np.minimum(upper - reached.upper, reached.lower - lower)
        for place, joint in enumerate(joints):
            room[place, order] = remaining[joint]
            if not remaining[joint] > 0.0:
                raise Infeasible(
                    f"joint {joint + 1}: the {name} of the base motion, {reached.lower[joint]:g} to "
                    f"{reached.upper[joint]:g}, leaves no room for a chirp within {lower[joint]:g} to "
                    f"{upper[joint]:g}. Try a slower motion, or rest in the middle of the range"
                )
    return room


def _safe(
    chirp: Chirp, limits: Limits, tick: float, resolution: float, clearances: Collection[Clearance]
) -> Chirp:
    """The chirp, scaled down until every stop ends inside the limits and there is no contact."""
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
                f"joint {joint + 1}: at {chirp.high:g} Hz the limits allow an amplitude of "
                f"{steps[-1, place] * resolution:.3g} rad, {steps[-1, place]:.2g} encoder steps of "
                f"{resolution:g} rad; at least {STEPS} are needed, from {first:.3g} Hz on it has fewer. "
                "Try a lower frequency, a larger share, or a slower base motion"
            )
