"""Steps: the inner loops of the plant, with numbers and arrays only, so that they can be compiled.

Named tuples are passed as plain tuples, which takes half the time.

Over a step the acceleration is constant and the equations hold in its middle (Newmark's average
acceleration), which is of second order and stable for any stiffness. Servo, springs and damping are implicit.
Friction that reverses abruptly would make the velocity oscillate if it were evaluated in the middle. The more
abrupt it is, the closer to the end of the step it is evaluated, as in the exact solution of linear equations.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg.lapack import dposv

from ...errors import RobotError

NO_INERTIA = (
    "the arm cannot be simulated, because its inertia is not positive definite. "
    "If the parameters are nominal, give every joint a rotor inertia and every link a mass. If they are "
    "fitted, the runs do not determine them: record a longer or faster motion, or fit with "
    "`--estimator consistent`"
)


class Elastic(NamedTuple):
    """Springs of m elastic gears, in the plant's x coordinates."""

    stretch: np.ndarray  # matrix that maps the coordinates to the twist of each spring, shape (m, x) [-]
    transposed: np.ndarray  # transpose of `stretch`, shape (x, m) [-]
    stiffness: np.ndarray  # stiffness, shape (m,) [N m/rad]
    damping: np.ndarray  # damping coefficient, shape (m,) [N m s/rad]
    play: np.ndarray  # play to either side, half the backlash, shape (m,) [rad]


class Cascade(NamedTuple):
    """The servo of n motors over a step of some duration."""

    turns: np.ndarray  # matrix that maps the coordinates to motor positions, shape (n, x) [-]
    transposed: np.ndarray  # transpose of `turns`, shape (x, n) [-]
    by_position: np.ndarray  # velocity from the position loop per coordinate, shape (n, x) [1/s]
    # Torque per velocity error, including its integral over half the step, shape (n,) [N m s/rad].
    stiff: np.ndarray
    integral_stiffness: np.ndarray  # torque per integral of the velocity error, shape (n,) [N m/rad]
    lag: np.ndarray  # velocity error per acceleration, shape (n,) [s]
    added_inertia: np.ndarray  # contribution of the servo to the inertia, shape (x, x) [kg m^2]
    limit: np.ndarray  # limit of the motor torque, shape (n,) [N m]


class Forces(NamedTuple):
    """Forces around a state, linear in velocity."""

    force: np.ndarray  # force needed to move on without acceleration, shape (x,) [N m]
    slope: np.ndarray  # derivative of the force by each velocity, shape (x,) [N m s/rad]
    velocity: np.ndarray  # velocity of the state, shape (x,) [rad/s]

    def moved(self, velocity: np.ndarray) -> "Forces":
        """Linear extrapolation of the forces to other velocities (x,) [rad/s]."""
        return Forces(self.force + self.slope * (velocity - self.velocity), self.slope, velocity)


Moved = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Position, velocity and acceleration (x,), and the servo's integral (n,)."""


def through(
    step: float,
    cascade: Cascade,
    elastic: Elastic,
    moved: Moved,
    inertia: np.ndarray,
    start: Forces,
    end: Forces,
    reference: np.ndarray,
) -> Moved:
    r"""Make a step for each reference (k, n), with forces that change linearly from start to end.

    Friction adds :math:`\theta h D` to the inertia of each joint, with :math:`\theta` between a half, the
    middle of the step, and one, its end. It approximates :math:`1 / (1 - e^{-z}) - 1 / z` with
    :math:`z = h D / M`, which is exact for a constant slope D.

    Raises:
        RobotError: If the arm has no inertia.
    """
    turns, transposed, by_position, stiff, integral_stiffness, lag, added_inertia, limit = cascade
    start_force, start_slope, start_velocity = start
    end_force, end_slope, end_velocity = end
    position, velocity, acceleration, integral = moved
    twelvefold = 12.0 * np.diag(inertia)
    for k in range(len(reference)):
        share = (k + 0.5) / len(reference)
        slope = start_slope + share * (end_slope - start_slope)
        nominal_velocity = start_velocity + share * (end_velocity - start_velocity)
        force = start_force + share * (end_force - start_force) + slope * (velocity - nominal_velocity)
        drag = step * slope
        steep = np.maximum(drag, 0.0)
        heavier = inertia + np.diag((0.5 + steep / (twelvefold + 2.0 * steep)) * drag)
        middle = position + 0.5 * step * velocity
        if position.size > integral.size:
            torque, weight = springs(elastic, middle, velocity, step)
            force, heavier = force + torque, heavier + weight
        error = reference[k] - turns @ velocity - by_position @ middle
        integral_torque = integral_stiffness * integral
        acceleration = solve(heavier + added_inertia, transposed @ (stiff * error + integral_torque) - force)
        velocity_error = error - lag * (turns @ acceleration)
        torque = stiff * velocity_error + integral_torque
        at_limit = np.abs(torque) > limit
        if at_limit.any():
            pull = transposed @ np.where(
                at_limit, np.copysign(limit, torque), stiff * error + integral_torque
            )
            free = (transposed * np.where(at_limit, 0.0, stiff * lag)) @ turns
            acceleration = solve(heavier + free, pull - force)
            velocity_error = np.where(at_limit, 0.0, error - lag * (turns @ acceleration))
        velocity = velocity + step * acceleration
        position = middle + 0.5 * step * velocity
        integral = integral + step * velocity_error
    return position, velocity, acceleration, integral


def springs(
    elastic: Elastic, position: np.ndarray, velocity: np.ndarray, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """Contribution of springs to a step: force in its middle without acceleration (x,), and inertia (x, x).

    Springs are linear unless a tooth gains or loses contact. The position (x,) [rad] is the one in the middle
    of the step [s] without acceleration, the velocity (x,) [rad/s] the one at its start.
    """
    stretch, transposed, stiffness, damping, play = elastic
    twist = stretch @ position
    in_contact = np.abs(twist) >= play
    stiffness, damping = stiffness * in_contact, damping * in_contact
    torque = stiffness * (twist - play * np.sign(twist)) + damping * (stretch @ velocity)
    weight = 0.25 * step**2 * stiffness + 0.5 * step * damping
    return transposed @ torque, (transposed * weight) @ stretch


def torque(cascade: Cascade, reference: np.ndarray, moved: Moved) -> np.ndarray:
    """Motor torque (n,) [N m] at one instant, on the joint side, by the cascade over a step of zero."""
    turns, _, by_position, stiff, integral_stiffness, _, _, limit = cascade
    position, velocity, _, integral = moved
    error = reference - turns @ velocity - by_position @ position
    unlimited = stiff * error + integral_stiffness * integral
    return np.minimum(np.maximum(unlimited, -limit), limit)


def solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of equations; raises `RobotError` if the matrix is not positive definite."""
    _, solution, failed = dposv(matrix, right)
    if failed:
        raise RobotError(NO_INERTIA)
    return solution


def solve_by_hand(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution by Cholesky decomposition, written to be compiled: Python takes a hundred times as long."""
    n = len(right)
    lower, solution = np.zeros((n, n)), np.empty(n)
    for row in range(n):
        for column in range(row + 1):
            remainder = matrix[row, column]
            for k in range(column):
                remainder -= lower[row, k] * lower[column, k]
            if row != column:
                lower[row, column] = remainder / lower[column, column]
            elif remainder > 0.0:
                lower[row, row] = np.sqrt(remainder)
            else:
                raise RobotError(NO_INERTIA)
        remainder = right[row]
        for k in range(row):
            remainder -= lower[row, k] * solution[k]
        solution[row] = remainder / lower[row, row]
    for row in range(n - 1, -1, -1):
        for k in range(row + 1, n):
            solution[row] -= lower[k, row] * solution[k]
        solution[row] /= lower[row, row]
    return solution


@cache
def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function compiled by Numba, ten times as fast; the function itself if Numba is not installed."""
    compiler = _compiler()
    if compiler is None:
        return function
    try:
        return compiler(cache=True)(function)
    except RuntimeError:  # there is no writable folder for the cache
        return compiler(function)


@cache
def _compiler() -> Callable[..., Any] | None:
    try:  # takes half a second, and only simulations need it
        from numba import njit
        from numba.extending import overload, register_jitable
    except ImportError:  # missing, or built for another NumPy
        return None
    overload(solve, strict=False)(lambda matrix, right: solve_by_hand)
    register_jitable(springs)
    return njit
