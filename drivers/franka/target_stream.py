"""Target stream: commands held back for a while and given out one each millisecond, or a stop.

The controller takes a stream without holes only: a command that is missing or comes twice is a jump of its
velocity. What the loop's computer is late by is taken from those that are held back. A command beyond one of
the controller's limits, as published for system 5.9 and later, is a reflex of the arm; here it is found
before it is sent.
"""

from collections import deque
from typing import NamedTuple

import numpy as np

JOINTS = 7
CYCLE = 0.001
"""Time between commands [s]."""
LOWER = np.array([-2.9007, -1.8361, -2.9007, -3.077, -2.8763, 0.4398, -3.0508])
UPPER = np.array([2.9007, 1.8361, 2.9007, -0.1169, 2.8763, 4.6216, 3.0508])
"""Positions [rad]."""
VELOCITY = np.array([2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26])
"""Far from the ends [rad/s]."""
END_DECELERATION = np.array([6.0, 2.585, 3.5, 4.0, 17.0, 5.5, 17.0])
END_VELOCITY = np.array([0.652, 0.25, 0.2005, 0.3542, 0.5738, 0.4885, 0.4592])
"""Near an end a joint may be as fast as this deceleration [rad/s^2] stops before it, less this [rad/s]."""
ACCELERATION = 10.0
"""Of every joint [rad/s^2]."""
JERK = 5000.0
"""Of every joint [rad/s^3]."""
ROUNDING = 1e-3
"""What is left to both sides' arithmetic, in the unit of the limit; as in the maker's own checks."""


def fastest(way: np.ndarray) -> np.ndarray:
    """Speed that is allowed so far before an end [rad], shape (n,) [rad/s]."""
    near = np.sqrt(np.maximum(2.0 * END_DECELERATION * way, 0.0)) - END_VELOCITY
    return np.clip(near, 0.0, VELOCITY)


class LimitCheck:
    """Looks at each command of a stream with one each millisecond, which begins at rest.

    Attributes:
        position: Last that was taken, shape (n,) [rad].
        velocity: Velocity of the commands there [rad/s].
        acceleration: Acceleration of the commands there [rad/s^2].
    """

    def __init__(self, start: np.ndarray) -> None:
        self.position = np.array(start)
        self.velocity, self.acceleration = np.zeros(len(start)), np.zeros(len(start))

    def look(self, position: np.ndarray) -> str:
        """Take a command; or what is beyond a limit in it, in words, and it is not taken."""
        velocity = (position - self.position) / CYCLE
        acceleration = (velocity - self.velocity) / CYCLE
        jerk = (acceleration - self.acceleration) / CYCLE
        way = np.where(velocity > 0.0, UPPER - position, position - LOWER)
        for words, value, limit, unit in (
            ("position", np.maximum(position - UPPER, LOWER - position), np.zeros(JOINTS), "rad beyond"),
            ("velocity", np.abs(velocity), fastest(way), "rad/s"),
            ("acceleration", np.abs(acceleration), np.full(JOINTS, ACCELERATION), "rad/s^2"),
            ("jerk", np.abs(jerk), np.full(JOINTS, JERK), "rad/s^3"),
        ):
            beyond = ~(value <= limit + ROUNDING)  # what is no number is beyond
            if beyond.any():
                joint = int(np.argmax(beyond))
                return (
                    f"joint {joint + 1}: commanded {words} is {value[joint]:.4g} {unit}, the controller "
                    f"takes {limit[joint]:.4g}"
                )
        self.position, self.velocity, self.acceleration = np.array(position), velocity, acceleration
        return ""


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


class Step(NamedTuple):
    """What the controller is given next: a position, shape (n,) [rad], and whether that is the end."""

    position: np.ndarray
    finished: bool


class TargetStream:
    """One motion from where the controller holds the arm (n,) [rad], to rest.

    So many commands are held back. `reason` is why it stops, empty while it does not.
    """

    def __init__(self, start: np.ndarray, held_back: int) -> None:
        self._waiting, self._held_back, self._begun = deque[np.ndarray](), held_back, False
        self._check = LimitCheck(start)
        self._stop: np.ndarray | None = None
        self._row = 0
        self.reason = ""

    def add(self, position: np.ndarray) -> None:
        """A command, shape (n,) [rad]; after a stop has begun it does not count."""
        self._waiting.append(position)

    def stop(self, reason: str) -> None:
        """From the next step on, come to rest."""
        if self._stop is None:
            self.reason = reason
            check = self._check
            self._stop = stopping(check.position, check.velocity, check.acceleration)

    def next(self, cycles: int) -> Step:
        """What belongs to now, so many cycles after the last step; those between are left out."""
        for _ in range(cycles):
            self._advance()
        if self._stop is None:
            return Step(self._check.position, False)
        row = min(self._row, len(self._stop)) - 1
        return Step(self._stop[max(row, 0)], row + 1 >= len(self._stop))

    def _advance(self) -> None:
        if self._stop is None:
            self._follow()
        if self._stop is not None:
            self._row += 1

    def _follow(self) -> None:
        self._begun = self._begun or len(self._waiting) >= self._held_back
        if not self._begun:
            return
        if not self._waiting:
            self.stop(
                f"no command for {1e3 * self._held_back * CYCLE:.0f} ms: the arm was stopped. Is this "
                "computer busy? Try a larger `buffer`"
            )
        elif wrong := self._check.look(self._waiting.popleft()):
            self.stop(f"{wrong}: the arm was stopped. Plan the motion within the limits of the FCI")
