"""Stepping: the arm's equations of motion under its servo, a fraction of a millisecond at a time.

Over a step the acceleration is constant and the equations hold in its middle (Newmark's average
acceleration), which is of second order and stable for any stiffness. Servo, springs and damping enter it
implicitly. Friction that turns abruptly would, with the plain middle, make the velocity jump from side to
side; it is weighted towards the end of the step the more, the more abrupt it is, as an exact solution of a
linear equation would be.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dposv

from ..errors import RobotError
from .arm_forces import Local
from .servo import Servo
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
        force: In the middle of each step, continued from there to no velocity by `slope`, shape (k, x) [N m].
        slope: Shape (k, x) [N m s/rad].
        reference: Of the servo, in the middle of each step, shape (k, n) [rad/s].
    """

    inertia: np.ndarray
    force: np.ndarray
    slope: np.ndarray
    reference: np.ndarray

    @classmethod
    def from_here(
        cls, inertia: np.ndarray, here: Local, velocity: np.ndarray, reference: np.ndarray
    ) -> "Stretch":
        """One step, with forces that change by the slope only."""
        force = here.force - here.slope * velocity
        return cls(inertia, force[None], here.slope[None], reference[None])

    @classmethod
    def between(
        cls,
        inertia: np.ndarray,
        ends: tuple[Local, Local],
        velocities: tuple[np.ndarray, np.ndarray],
        reference: np.ndarray,
    ) -> "Stretch":
        """Steps with forces that change evenly from one state to another, which was foreseen."""
        count, (start, end) = len(reference), ends
        share = ((np.arange(count) + 0.5) / count)[:, None]
        slope = start.slope + share * (end.slope - start.slope)
        velocity = velocities[0] + share * (velocities[1] - velocities[0])
        force = start.force + share * (end.force - start.force) - slope * velocity
        return cls(inertia, force, slope, reference)


class Stepping:
    """Steps of one length, servo and transmission.

    Args:
        servo: Its control.
        springs: Its elastic gears.
        step: [s].
    """

    def __init__(self, servo: Servo, springs: Springs, step: float) -> None:
        self._step, self._springs = step, springs
        self._turns, self._back, self._limit = servo.turns, servo.turns.T.copy(), servo.limit
        self._by_position = servo.position_gain[:, None] * servo.turns
        self._stiff = servo.velocity_gain * (1.0 + 0.5 * step * servo.integral_gain)
        self._kept = servo.velocity_gain * servo.integral_gain
        self._lag = 0.5 * step + 0.25 * step**2 * servo.position_gain
        self._held = self._pull(self._stiff)

    def _pull(self, stiff: np.ndarray) -> np.ndarray:
        """What a servo as stiff as this adds to the inertia, shape (x, x) [kg m^2]."""
        return (self._back * (stiff * self._lag)) @ self._turns

    def through(self, state: State, stretch: Stretch) -> State:
        """The state after all steps of a stretch.

        Raises:
            RobotError: An arm without inertia.
        """
        inertia, weight = stretch.inertia, self._friction(stretch)
        for k, force in enumerate(stretch.force):
            moved = inertia.copy()
            moved.reshape(-1)[:: len(inertia) + 1] += weight[k]
            state = self._go(state, moved, force + stretch.slope[k] * state.velocity, stretch.reference[k])
        return state

    def _friction(self, stretch: Stretch) -> np.ndarray:
        r"""What friction adds to the inertia of each joint, shape (k, x) [kg m^2].

        That is :math:`\theta h D`, with :math:`\theta` from a half, the middle, to one, the end of the step:
        nearly :math:`1 / (1 - e^{-z}) - 1 / z`, :math:`z = h D / M`, which is exact for a constant slope.
        """
        drag = self._step * stretch.slope
        steep = np.maximum(drag, 0.0)
        return (0.5 + steep / (12.0 * stretch.inertia.diagonal() + 2.0 * steep)) * drag

    def _go(self, state: State, inertia: np.ndarray, force: np.ndarray, reference: np.ndarray) -> State:
        """One step against a force (x,) [N m]."""
        step, (position, velocity, _, integral) = self._step, state
        middle = position + 0.5 * step * velocity
        if not self._springs.empty:
            torque, weight = self._springs.linear(middle, velocity, step)
            force, inertia = force + torque, inertia + weight
        error = reference - self._turns @ velocity - self._by_position @ middle
        kept = self._kept * integral
        acceleration = _solve(inertia + self._held, self._back @ (self._stiff * error + kept) - force)
        left = error - self._lag * (self._turns @ acceleration)
        torque = self._stiff * left + kept
        beyond = np.abs(torque) > self._limit
        if beyond.any():
            limit = np.copysign(self._limit, torque)
            pull = self._back @ np.where(beyond, limit, self._stiff * error + kept)
            acceleration = _solve(inertia + self._pull(np.where(beyond, 0.0, self._stiff)), pull - force)
            left = np.where(beyond, 0.0, error - self._lag * (self._turns @ acceleration))
        return State(
            middle + 0.5 * step * (velocity + step * acceleration),
            velocity + step * acceleration,
            acceleration,
            integral + step * left,
        )


def require_inertia(inertia: np.ndarray) -> None:
    """Raise where an arm of this inertia (x, x) would have nothing to be accelerated.

    Raises:
        RobotError: It is not positive definite.
    """
    _solve(inertia, np.zeros(len(inertia)))


def _solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    _, solution, failed = dposv(matrix, right)
    if failed:
        raise RobotError(
            "the simulated arm has directions without inertia, in which it cannot move; give every joint a "
            "rotor inertia, and every link a mass"
        )
    return solution
