"""A stop: from any state of a stream of commands to rest, inside the controller's limits."""

import numpy as np

from .fci_limits import ACCELERATION, CYCLE, JERK

SHARE = 0.95
"""Of the limits, so that rounding does not matter [-]."""
SHORTEST, LONGEST = 0.01, 2.0
"""Of stops [s]; within the longest, twice the speed of any joint ends."""
LONGER = 1.1
"""Of a trial, over the one before."""


def stopping(position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """Positions at each of the next milliseconds until the arm rests, shape (t, n) [rad].

    Speed is the cubic of time that begins with this velocity [rad/s] and acceleration [rad/s^2] and ends with
    neither; all joints take as long as the slowest needs.
    """
    seconds = SHORTEST
    while seconds < LONGEST and not _inside(velocity, acceleration, seconds):
        seconds *= LONGER
    time = np.arange(1, round(seconds / CYCLE) + 1)[:, None] * CYCLE
    return position + _way(velocity, acceleration, time, len(time) * CYCLE)


def _inside(velocity: np.ndarray, acceleration: np.ndarray, seconds: float) -> bool:
    """Whether a stop of that length keeps the limits: acceleration is a parabola, jerk a straight line."""
    square, cube = _coefficients(velocity, acceleration, seconds)
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.nan_to_num(-square / (3.0 * cube), posinf=0.0, neginf=0.0)
    turn = np.clip(turn, 0.0, seconds)
    most = np.abs(acceleration + 2.0 * square * turn + 3.0 * cube * turn**2)
    jerk = np.maximum(np.abs(2.0 * square), np.abs(2.0 * square + 6.0 * cube * seconds))
    return bool(np.all(most <= np.maximum(SHARE * ACCELERATION, np.abs(acceleration)))) and bool(
        np.all(jerk <= SHARE * JERK)
    )


def _coefficients(
    velocity: np.ndarray, acceleration: np.ndarray, seconds: float
) -> tuple[np.ndarray, np.ndarray]:
    """Of the square and the cube of time in the velocity."""
    square = -(3.0 * velocity + 2.0 * acceleration * seconds) / seconds**2
    cube = (2.0 * velocity + acceleration * seconds) / seconds**3
    return square, cube


def _way(velocity: np.ndarray, acceleration: np.ndarray, time: np.ndarray, seconds: float) -> np.ndarray:
    square, cube = _coefficients(velocity, acceleration, seconds)
    way: np.ndarray = velocity * time + acceleration * time**2 / 2 + square * time**3 / 3 + cube * time**4 / 4
    return way
