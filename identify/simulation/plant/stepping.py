"""Stepping: the arm's equations of motion under its servo, a fraction of a millisecond at a time."""

from typing import NamedTuple

import numpy as np

from . import compiled
from .servo import Servo
from .steps import Elastic, Forces, solve


class State(NamedTuple):
    """Of the arm and its servo.

    Attributes:
        position: In the plant's coordinates, shape (x,) [rad].
        velocity: Shape (x,) [rad/s].
        acceleration: Over the last step, shape (x,) [rad/s^2].
        integral: Of each motor's velocity error, shape (n,) [rad].
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    integral: np.ndarray


class Stepping:
    """Steps of one length, servo and transmission.

    Args:
        servo: Its control.
        springs: Its elastic gears.
        step: [s].
    """

    def __init__(self, servo: Servo, springs: Elastic, step: float) -> None:
        self._through = compiled.through()
        self._constants = step, tuple(servo.over(step)), tuple(springs)

    def through(
        self, state: State, inertia: np.ndarray, start: Forces, end: Forces, reference: np.ndarray
    ) -> State:
        """The state after some steps.

        Args:
            state: That they begin with.
            inertia: Shape (x, x) [kg m^2].
            start: Forces around that state.
            end: Forces around another, which was foreseen; they change evenly from one to the other.
            reference: Of the servo, in the middle of each step, shape (k, n) [rad/s].

        Raises:
            RobotError: An arm without inertia.
        """
        known = tuple(state), inertia, tuple(start), tuple(end), reference
        return State(*self._through(*self._constants, *known))


def require_inertia(inertia: np.ndarray) -> None:
    """Raise where an arm of this inertia (x, x) would have nothing to be accelerated.

    Raises:
        RobotError: It is not positive definite.
    """
    solve(inertia, np.zeros(len(inertia)))
