"""Stepping: the arm's equations of motion under its servo, a fraction of a millisecond at a time."""

from typing import NamedTuple

import numpy as np

from . import compiled
from .arm_forces import Local
from .servo import Servo
from .steps import Cascade, Forces, solve
from .transmission import Springs


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


class Stretch(NamedTuple):
    """What is known of one or several steps in advance.

    Attributes:
        inertia: Shape (x, x) [kg m^2].
        start: Forces around the state they begin with.
        end: Forces around another, which was foreseen; they change evenly from one to the other.
        reference: Of the servo, in the middle of each step, shape (k, n) [rad/s].
    """

    inertia: np.ndarray
    start: Forces
    end: Forces
    reference: np.ndarray

    @classmethod
    def from_here(
        cls, inertia: np.ndarray, here: Local, velocity: np.ndarray, reference: np.ndarray
    ) -> "Stretch":
        """One step, with forces that change by the slope only."""
        forces = Forces(*here, velocity)
        return cls(inertia, forces, forces, reference[None])

    @classmethod
    def between(
        cls,
        inertia: np.ndarray,
        ends: tuple[Local, Local],
        velocities: tuple[np.ndarray, np.ndarray],
        reference: np.ndarray,
    ) -> "Stretch":
        """Steps with forces that change evenly from one state to another, which was foreseen."""
        start, end = (Forces(*local, velocity) for local, velocity in zip(ends, velocities, strict=True))
        return cls(inertia, start, end, reference)


class Stepping:
    """Steps of one length, servo and transmission.

    Args:
        servo: Its control.
        springs: Its elastic gears.
        step: [s].
    """

    def __init__(self, servo: Servo, springs: Springs, step: float) -> None:
        stiff = servo.velocity_gain * (1.0 + 0.5 * step * servo.integral_gain)
        lag = 0.5 * step + 0.25 * step**2 * servo.position_gain
        back = servo.turns.T.copy()
        self._step, self._elastic, self._through = step, springs.elastic, compiled.through()
        self._cascade = Cascade(
            turns=servo.turns,
            back=back,
            by_position=servo.position_gain[:, None] * servo.turns,
            stiff=stiff,
            kept=servo.velocity_gain * servo.integral_gain,
            lag=lag,
            held=(back * (stiff * lag)) @ servo.turns,
            limit=servo.limit,
        )

    def through(self, state: State, stretch: Stretch) -> State:
        """The state after all steps of a stretch.

        Raises:
            RobotError: An arm without inertia.
        """
        return State(*self._through(self._step, self._cascade, self._elastic, tuple(state), *stretch))


def require_inertia(inertia: np.ndarray) -> None:
    """Raise where an arm of this inertia (x, x) would have nothing to be accelerated.

    Raises:
        RobotError: It is not positive definite.
    """
    solve(inertia, np.zeros(len(inertia)))
