"""What the controller of an FR3 takes of a stream of joint positions, as published for system 5.9 and later.

A command beyond one of these is a reflex of the arm; here it is found before it is sent.
"""

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
    """Looks at each command of a stream with one each millisecond.

    Args:
        start: Where it begins at rest, shape (n,) [rad].

    Attributes:
        position: Last that was taken, shape (n,) [rad].
        velocity: Of the commands there [rad/s].
        acceleration: Likewise [rad/s^2].
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
