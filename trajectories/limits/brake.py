r"""How far a joint goes on while it stops: in closed form, for many states at once, with derivatives.

The fastest stop of a joint brings velocity and acceleration to zero with jerk :math:`\pm j` and an
acceleration inside its limits. What would be left of the velocity if the acceleration were only taken
back, :math:`v + a |a| / 2j`, gives the direction to push. Where it is positive (else everything is mirrored),
with the backward acceleration limit :math:`-d`:

1. the acceleration goes to :math:`-r`, the smaller of :math:`d` and :math:`p = \sqrt{v j + a^2/2}`;
2. stays there for a time :math:`t_2`, zero unless :math:`p > d`;
3. goes back to zero.

The velocity changes sign at most once, in the first part, where it began negative.
"""

from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..trajectory import States
from .usable_limits import require_jerk


class Reach(NamedTuple):
    """How far a stop goes from where it begins.

    Attributes:
        lower: Most negative displacement, zero or below, shape (t, n) [rad].
        upper: Most positive displacement, zero or above, shape (t, n) [rad].
    """

    lower: np.ndarray
    upper: np.ndarray


def stopping_reach(velocity: np.ndarray, acceleration: np.ndarray, limits: Limits) -> Reach:
    """How far each joint goes down and up while it stops as fast as it can.

    Args:
        velocity: Shape (t, n) [rad/s].
        acceleration: Shape (t, n) [rad/s^2]; may be beyond its limits, and is then brought inside first.
        limits: Acceleration (directional) and jerk.

    Raises:
        BadLimits: Limits within which no joint can stop.
    """
    low, high = _low_and_high(velocity, acceleration, limits)
    return Reach(low[0], high[0])


def stopping_reach_gradient(
    velocity: np.ndarray, acceleration: np.ndarray, limits: Limits
) -> tuple[Reach, Reach]:
    """Derivatives of `stopping_reach`, of the same arguments, by velocity [s] and acceleration [s^2].

    Exact but where the reach itself has a kink: where the arm begins to turn on the way, where its end
    comes back to where it began, and at rest.
    """
    low, high = _low_and_high(velocity, acceleration, limits)
    return Reach(low[1], high[1]), Reach(low[2], high[2])


def stoppable(states: States, limits: Limits) -> np.ndarray:
    """Whether a stop begun in each state stays inside the position limits, shape (t, n)."""
    reach = stopping_reach(states.velocity, states.acceleration, limits)
    inside_below = states.position + reach.lower >= limits.position_lower
    return inside_below & (states.position + reach.upper <= limits.position_upper)


def _low_and_high(
    velocity: np.ndarray, acceleration: np.ndarray, limits: Limits
) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest displacement, each (3, t, n): value, derivatives by velocity and acceleration."""
    require_jerk(limits)
    left = velocity + 0.5 * acceleration * np.abs(acceleration) / limits.jerk
    sign = np.where(left < 0.0, -1.0, 1.0)
    backward = np.where(left < 0.0, limits.acceleration, -limits.acceleration_lower)
    v, a = sign * velocity, sign * acceleration
    turn, end = _turn(v, a, limits.jerk), _end(v, a, limits.jerk, backward)
    end = np.where(end[0] < 0.0, 0.0, end)  # never beyond where it began
    mirror = np.stack([sign, np.ones_like(sign), np.ones_like(sign)])  # of a displacement and its derivatives
    forward = sign > 0
    return mirror * np.where(forward, turn, end), mirror * np.where(forward, end, turn)


def _turn(velocity: np.ndarray, acceleration: np.ndarray, jerk: np.ndarray) -> np.ndarray:
    """Lowest point, where the velocity comes through zero from below; zero where it never was below."""
    below = velocity < 0.0
    v, a = np.where(below, velocity, 0.0), np.where(below, acceleration, 1.0)
    time = -2 * v / (a + np.sqrt(np.maximum(a**2 + 2 * jerk * v, 0.0)))  # cannot cancel: both are positive
    # The velocity is zero there, so a shift of that time moves nothing: derivatives at fixed time.
    return np.stack([time * (v + time * (a / 2 - time * jerk / 6)), time, time**2 / 2])


def _end(velocity: np.ndarray, acceleration: np.ndarray, jerk: np.ndarray, most: np.ndarray) -> np.ndarray:
    """Where it comes to rest, for states that need a push backward of at most `most`."""
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
