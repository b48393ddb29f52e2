"""`Measurement`: an effect between an arm and its recordings that is not a torque of rigid joints.

Its numbers are fields, not linear parameters: a diagnosis finds them, or a robot file states them. A fit
removes the effect from recordings, and a simulation adds it; both use the same object.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from ..errors import RobotError


@dataclass(frozen=True)
class Measurement:
    """Effect between an arm and its recordings; a subclass overrides the methods that it changes."""

    def delay(self, robot: Robot) -> np.ndarray:
        """Delay of each joint's recorded effort relative to its position, shape (n,) [s]."""
        return np.zeros(robot.dof)

    def current_limit(self, robot: Robot) -> np.ndarray:
        """Largest recorded effort of each joint, shape (n,) [A; N m if torque is recorded]."""
        return np.full(robot.dof, np.inf)

    def recorded(self, robot: Robot, torque: np.ndarray) -> np.ndarray:
        """Drive gains times recorded currents at motor torques (..., n), same shape [N m]."""
        return torque

    def restored(self, robot: Robot, shown: np.ndarray) -> np.ndarray:
        """Motor torques from drive gains times recorded currents (t, n), same shape [N m]."""
        return shown

    def check(self, robot: Robot) -> None:
        """Check numbers and joints.

        Raises:
            UnknownJoint: The robot has no such joint.
            RobotError: A number is outside its range.
        """
        self.delay(robot)
        self.current_limit(robot)


def require(effect: str, name: str, value: float, above: bool = True) -> None:
    """Raise `RobotError` unless a number of an effect is above 0, or at least 0 if `above` is false."""
    if not (value > 0.0 if above else value >= 0.0):
        raise RobotError(f"{effect} {name}: {value:g} is not {'above' if above else 'at least'} 0")


def on_joints(robot: Robot, joints: Sequence[str] | None, value: float, elsewhere: float) -> np.ndarray:
    """Array with `value` for the named joints (None for all) and `elsewhere` for the others, shape (n,)."""
    values = np.full(robot.dof, value if joints is None else elsewhere)
    for joint in joints or ():
        values[robot.index(joint)] = value
    return values
