"""What it means to put an effect into a robot.

An effect takes a robot, a joint, a strength and random numbers, and gives the robot with the effect.
Strength 1 is about one noise floor; what it really is, is measured. Torques are scaled by the joint's
noise floor.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..robots.robot import Robot


@dataclass(frozen=True)
class Concealed:
    """A robot with something concealed in it."""

    robot: Robot  # With the effect
    # Without it; what is recorded of both differs by the effect's torque, `part` of it if the effect cannot
    # be taken away altogether
    sound: Robot
    joints: tuple[int, ...]  # Where it is, counted from 0; empty where it belongs to the whole arm
    parameters: dict[str, Any]  # Its entry in a truth file
    part: float = 1.0  # Share of the effect by which the two robots differ [-]
    span: tuple[float, float] = (0.0, np.inf)  # Times of the run between which it is there [s]


Conceal = Callable[[Robot, int, float, np.random.Generator], Concealed]


def changed(values: np.ndarray, place: Any, value: Any) -> np.ndarray:
    """A copy with one entry, or row, replaced."""
    copy = np.array(values, float)
    copy[place] = value
    return copy


def floor(robot: Robot, joint: int) -> float:
    """Noise floor of a joint [N m]."""
    return float(robot.recorder.floor[joint])
