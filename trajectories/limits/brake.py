r"""Distance that a joint travels while it stops: closed form, vectorized over states, with derivatives.

The fastest stop of a joint brings velocity and acceleration to zero with jerk :math:`\pm j` and an
acceleration inside its limits. The velocity that remains after the acceleration alone is brought to zero,
:math:`v + a |a| / 2j`, gives the direction of the stop. If it is positive (otherwise everything is mirrored),
with the backward acceleration limit :math:`-d`:

1. the acceleration goes to :math:`-r`, the smaller of :math:`d` and :math:`p = \sqrt{v j + a^2/2}`;
2. it stays there for a time :math:`t_2`, zero unless :math:`p > d`;
3. it returns to zero.

The velocity changes sign at most once, in the first part, if it was negative at the start.
"""

from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..trajectory import States
from .usable_limits import require_jerk


class Reach(NamedTuple):
    """Displacements during a stop, relative to the position at which it begins."""

    lower: np.ndarray  # most negative displacement, zero or below, shape (t, n) [rad]
    upper: np.ndarray  # most positive displacement, zero or above, shape (t, n) [rad]


def stopping_reach(velocity: np.ndarray, acceleration: np.ndarray, limits: Limits) -> Reach:
    """Most negative and most positive displacement of each joint during its fastest stop.

    The stop begins at a velocity [rad/s] and acceleration [rad/s^2], both (t, n), and keeps to the limits of
    acceleration, which are directional, and jerk. An acceleration beyond its limits is brought inside first.

    Raises:
        BadLimits: No joint can stop within the limits.
    """
    low, high = _low_and_high(velocity, acceleration, limits)
    return Reach(low[0], high[0])


def stopping_reach_gradient(
    velocity: np.ndarray, acceleration: np.ndarray, limits: Limits
) -> tuple[Reach, Reach]:
    """Derivatives of `stopping_reach` by velocity [s] and acceleration [s^2], for the same arguments.

    They are exact except where the reach has a kink: where the joint begins to reverse during the stop, where
    the stop ends at the position at which it began, and at rest.
    """
    low, high = _low_and_high(velocity, acceleration, limits)
    return Reach(low[1], high[1]), Reach(low[2], high[2])


def stoppable(states: States, limits: Limits) -> np.ndarray:
    """Whether a stop that begins in each state stays inside the position limits, shape (t, n)."""
    reach = stopping_reach(states.velocity, states.acceleration, limits)
    inside_below = states.position + reach.lower >= limits.position_lower
    return inside_below & (states.position + reach.upper <= limits.position_upper)


def _low_and_high(
    velocity: np.ndarray, acceleration: np.ndarray, limits: Limits
) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest displacement, each with its derivatives by velocity and acceleration, (3, t, n)."""
    require_jerk(limits)
    remaining = velocity + 0.5 * acceleration * np.abs(acceleration) / limits.jerk
    sign = np.where(remaining < 0.0, -1.0, 1.0)
    backward = np.where(remaining < 0.0, limits.acceleration, -limits.acceleration_lower)
    v, a = sign * velocity, sign * acceleration
    turn, end = _turn(v, a, limits.jerk), _end(v, a, limits.jerk, backward)
    end = np.where(end[0] < 0.0, 0.0, end)  # not beyond the position at the start
    mirror = np.stack([sign, np.ones_like(sign), np.ones_like(sign)])  # of a displacement and its derivatives
    forward = sign > 0
    return mirror * np.where(forward, turn, end), mirror * np.where(forward, end, turn)


def _turn(velocity: np.ndarray, acceleration: np.ndarray, jerk: np.ndarray) -> np.ndarray:
    """Lowest displacement, where the velocity crosses zero from below; zero if it was never negative."""
    below = velocity < 0.0
    v, a = np.where(below, velocity, 0.0), np.where(below, acceleration, 1.0)
    time = -2 * v / (a + np.sqrt(np.maximum(a**2 + 2 * jerk * v, 0.0)))  # cannot cancel: both are positive
    # The velocity is zero there, so the derivative by that time is zero: derivatives at fixed time.
    return np.stack([time * (v + time * (a / 2 - time * jerk / 6)), time, time**2 / 2])


def _end(velocity: np.ndarray, acceleration: np.ndarray, jerk: np.ndarray, most: np.ndarray) -> np.ndarray:
    """Displacement at the end of the stop, for states that need a backward acceleration of at most `most`."""
    v, a = velocity, acceleration
    peak = np.sqrt(np.maximum(v * jerk + a**2 / 2, 0.0))
    push = np.minimum(peak, most)
    side = np.where(a + push < 0.0, -1.0, 1.0)  # -1 where the acceleration begins beyond its limit
    first = np.abs(a + push) / jerk
    v_held = v + side * (a**2 - push**2) / (2 * jerk)
    held = np.where(peak > most, v_held - push**2 / (2 * jerk), 0.0) / np.where(push > 0.0, push, 1.0)
    end = first * (v + first * (a / 2 - side * first * jerk / 6))
    end += held * (v_held - held * push / 2) + push**3 / (6 * jerk**2)
    by_velocity = first + held + push / (2 * jerk)
    by_acceleration = first**2 / 2 + side * (v_held / jerk + held * a / jerk + push * a / (2 * jerk**2))
    return np.stack([end, by_velocity, by_acceleration])
