"""Measurement: something between an arm and its recordings that is no torque of rigid joints.

Its numbers are fields, not linear unknowns: a diagnosis finds them, or a robot file states them. A fit takes
the effect out of recordings, and a simulation puts it in; both ask the same object.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from ..errors import RobotError


@dataclass(frozen=True)
class Measurement:
    """One such effect; a subclass overrides what it changes."""

    def delay(self, robot: Robot) -> np.ndarray:
        """Time by which the effort of each joint is recorded later than its position, shape (n,) [s]."""
        return np.zeros(robot.dof)

    def current_limit(self, robot: Robot) -> np.ndarray:
        """Largest effort of each joint that is recorded, shape (n,) [A; N m where torque is recorded]."""
        return np.full(robot.dof, np.inf)

    def recorded(self, robot: Robot, torque: np.ndarray) -> np.ndarray:
        """Drive gains times the currents that are recorded at motor torques (..., n), as many [N m]."""
        return torque

    def restored(self, robot: Robot, shown: np.ndarray) -> np.ndarray:
        """Motor torques for drive gains times recorded currents (t, n), as many [N m]."""
        return shown

    def check(self, robot: Robot) -> None:
        """Raise an error where a number or a joint cannot be.

        Raises:
            UnknownJoint: The robot has no such joint.
            RobotError: A number is outside of its range.
        """
        self.delay(robot)
        self.current_limit(robot)


def require(effect: str, name: str, value: float, above: bool = True) -> None:
    """Raise `RobotError` where a number of an effect is not above 0, or, if `above` is false, below 0."""
    if not (value > 0.0 if above else value >= 0.0):
        raise RobotError(f"{effect} {name}: {value:g} is not {'above' if above else 'at least'} 0")


def on_joints(robot: Robot, joints: Sequence[str] | None, value: float, elsewhere: float) -> np.ndarray:
    """A value on some joints, on all for None, and another elsewhere, shape (n,)."""
    values = np.full(robot.dof, value if joints is None else elsewhere)
    for joint in joints or ():
        values[robot.index(joint)] = value
    return values
