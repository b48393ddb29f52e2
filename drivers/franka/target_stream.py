"""Target stream: commands that are held back and sent one per millisecond, or a stop.

The controller needs a stream without gaps: a missing or repeated command is a jump of the velocity. Commands
that are held back bridge delays of the host. A command that exceeds a limit of the controller, as published
for system 5.9 and later, would trigger a reflex of the arm; it is detected here before it is sent.
"""

from collections import deque
from typing import NamedTuple

import numpy as np

JOINTS = 7
CYCLE = 0.001
"""Time between commands [s]."""
LOWER = np.array([-2.9007, -1.8361, -2.9007, -3.077, -2.8763, 0.4398, -3.0508])
UPPER = np.array([2.9007, 1.8361, 2.9007, -0.1169, 2.8763, 4.6216, 3.0508])
"""Position limits [rad]."""
VELOCITY = np.array([2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26])
"""Velocity limits far from the position limits [rad/s]."""
END_DECELERATION = np.array([6.0, 2.585, 3.5, 4.0, 17.0, 5.5, 17.0])
END_VELOCITY = np.array([0.652, 0.25, 0.2005, 0.3542, 0.5738, 0.4885, 0.4592])
"""Velocity limit near a position limit: the velocity from which this deceleration [rad/s^2] stops the joint
in time, minus this velocity [rad/s]."""
ACCELERATION = 10.0
"""Acceleration limit of every joint [rad/s^2]."""
JERK = 5000.0
"""Jerk limit of every joint [rad/s^3]."""
ROUNDING = 1e-3
"""Tolerance for rounding, in the unit of the limit, as in the maker's checks."""


def fastest(distance: np.ndarray) -> np.ndarray:
    """Velocity limits at a distance to the position limits [rad], shape (n,) [rad/s]."""
    limit = np.sqrt(np.maximum(2.0 * END_DECELERATION * distance, 0.0)) - END_VELOCITY
    return np.clip(limit, 0.0, VELOCITY)


class LimitCheck:
    """Checks each command of a stream with one command per millisecond, which begins at rest."""

    def __init__(self, start: np.ndarray) -> None:
        self.position = np.array(start)  # last accepted position, shape (n,) [rad]
        self.velocity = np.zeros(len(start))  # velocity of the commands there, shape (n,) [rad/s]
        self.acceleration = np.zeros(len(start))  # their acceleration, shape (n,) [rad/s^2]

    def look(self, position: np.ndarray) -> str:
        """Check a command; returns which limit it exceeds, or an empty text if it is accepted."""
        velocity = (position - self.position) / CYCLE
        acceleration = (velocity - self.velocity) / CYCLE
        jerk = (acceleration - self.acceleration) / CYCLE
        distance = np.where(velocity > 0.0, UPPER - position, position - LOWER)
        for words, value, limit, unit in (
            ("position", np.maximum(position - UPPER, LOWER - position), np.zeros(JOINTS), "rad beyond"),
            ("velocity", np.abs(velocity), fastest(distance), "rad/s"),
            ("acceleration", np.abs(acceleration), np.full(JOINTS, ACCELERATION), "rad/s^2"),
            ("jerk", np.abs(jerk), np.full(JOINTS, JERK), "rad/s^3"),
        ):
            beyond = ~(value <= limit + ROUNDING)  # true for NaN
            if beyond.any():
                joint = int(np.argmax(beyond))
                return (
                    f"joint {joint + 1}: commanded {words} is {value[joint]:.4g} {unit}, limit of the "
                    f"controller {limit[joint]:.4g}"
                )
        self.position, self.velocity, self.acceleration = np.array(position), velocity, acceleration
        return ""


SHARE = 0.95
"""Fraction of the limits that a stop uses, so that rounding does not matter [-]."""
SHORTEST, LONGEST = 0.01, 2.0
"""Shortest and longest duration of a stop [s]; the longest stops twice the velocity of any joint."""
LONGER = 1.1
"""Ratio of the durations of successive trials [-]."""


def stopping(position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """Positions in each of the next milliseconds until the arm rests, shape (t, n) [rad].

    The velocity is the cubic of time that begins with this velocity [rad/s] and acceleration [rad/s^2] and
    ends at zero for both; all joints take as long as the slowest joint.
    """
    seconds = SHORTEST
    while seconds < LONGEST and not _keeps_limits(velocity, acceleration, seconds):
        seconds *= LONGER
    time = np.arange(1, round(seconds / CYCLE) + 1)[:, None] * CYCLE
    return position + _displacement(velocity, acceleration, time, len(time) * CYCLE)


def _keeps_limits(velocity: np.ndarray, acceleration: np.ndarray, seconds: float) -> bool:
    """Whether a stop of this duration keeps the limits: acceleration is a parabola, jerk a straight line."""
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
    """Coefficients of the square and the cube of time in the velocity."""
    square = -(3.0 * velocity + 2.0 * acceleration * seconds) / seconds**2
    cube = (2.0 * velocity + acceleration * seconds) / seconds**3
    return square, cube


def _displacement(
    velocity: np.ndarray, acceleration: np.ndarray, time: np.ndarray, seconds: float
) -> np.ndarray:
    square, cube = _coefficients(velocity, acceleration, seconds)
    displacement: np.ndarray = (
        velocity * time + acceleration * time**2 / 2 + square * time**3 / 3 + cube * time**4 / 4
    )
    return displacement


class Step(NamedTuple):
    """Next command to the controller: a position, shape (n,) [rad], and whether it is the last."""

    position: np.ndarray
    finished: bool


class TargetStream:
    """Commands of one motion, from the position held by the controller, (n,) [rad], to rest."""

    def __init__(self, start: np.ndarray, held_back: int) -> None:
        self._waiting, self._held_back, self._begun = deque[np.ndarray](), held_back, False
        self._check = LimitCheck(start)
        self._stop: np.ndarray | None = None
        self._row = 0
        self.reason = ""  # why the stream stops; empty while it does not

    def add(self, position: np.ndarray) -> None:
        """Add a command, shape (n,) [rad]; it is ignored once a stop has begun."""
        self._waiting.append(position)

    def stop(self, reason: str) -> None:
        """Begin to stop with the next step."""
        if self._stop is None:
            self.reason = reason
            check = self._check
            self._stop = stopping(check.position, check.velocity, check.acceleration)

    def next(self, cycles: int) -> Step:
        """Command that is due `cycles` cycles after the last step; commands in between are skipped."""
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
