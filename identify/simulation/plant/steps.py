"""Steps: the inner loops of the plant, of numbers and arrays only, so that they can be compiled.

Tuples that have names are handed over without them, which takes half as long.

Over a step the acceleration is constant and the equations hold in its middle (Newmark's average
acceleration), which is of second order and stable for any stiffness. Servo, springs and damping enter it
implicitly. Friction that reverses abruptly would, with the plain middle, make the velocity jump from side to
side; it is weighted towards the end of the step the more, the more abrupt it is, as an exact solution of a
linear equation would be.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg.lapack import dposv

from ...errors import RobotError

NO_INERTIA = (
    "the simulated arm has directions in which its inertia is not above zero, and cannot be simulated. "
    "Nominal parameters: give every joint a rotor inertia, and every link a mass. Fitted ones: these runs "
    "do not determine them; a longer or faster motion does, and `--estimator consistent` keeps them physical"
)


class Elastic(NamedTuple):
    """Springs of gears that give way, in the plant's coordinates x; m of them.

    Attributes:
        stretch: Twist of each spring out of the coordinates, shape (m, x) [-].
        back: Its transpose, shape (x, m) [-].
        stiffness: Shape (m,) [N m/rad].
        damping: Shape (m,) [N m s/rad].
        play: To either side, shape (m,) [rad].
    """

    stretch: np.ndarray
    back: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    play: np.ndarray


class Cascade(NamedTuple):
    """The servo of n motors over a step of given length.

    Attributes:
        turns: Motors' positions out of the coordinates, shape (n, x) [-].
        back: Its transpose, shape (x, n) [-].
        by_position: Velocity that the position loop asks for, shape (n, x) [1/s].
        stiff: Torque per velocity error, its integral over half the step included, shape (n,) [N m s/rad].
        kept: Torque per integral, shape (n,) [N m/rad].
        lag: By which acceleration shows in the velocity error, shape (n,) [s].
        held: What all that adds to the inertia, shape (x, x) [kg m^2].
        limit: Limit of the motors' torque, shape (n,) [N m].
    """

    turns: np.ndarray
    back: np.ndarray
    by_position: np.ndarray
    stiff: np.ndarray
    kept: np.ndarray
    lag: np.ndarray
    held: np.ndarray
    limit: np.ndarray


class Forces(NamedTuple):
    """Forces around a state, linear in velocity.

    Attributes:
        force: That it takes to go on without acceleration, shape (x,) [N m].
        slope: By each velocity, shape (x,) [N m s/rad].
        velocity: Velocity of the state, shape (x,) [rad/s].
    """

    force: np.ndarray
    slope: np.ndarray
    velocity: np.ndarray

    def moved(self, velocity: np.ndarray) -> "Forces":
        """The same around a state with other velocities (x,) [rad/s]."""
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
    r"""Make a step for each reference (k, n), with forces that change evenly from start to end.

    Friction adds :math:`\theta h D` to the inertia of each joint, with :math:`\theta` from a half, the
    middle, to one, the end of the step: nearly :math:`1 / (1 - e^{-z}) - 1 / z`, :math:`z = h D / M`, which
    is exact for a constant slope D.

    Raises:
        RobotError: An arm without inertia.
    """
    turns, back, by_position, stiff, kept_share, lag, held, limit = cascade
    start_force, start_slope, start_velocity = start
    end_force, end_slope, end_velocity = end
    position, velocity, acceleration, integral = moved
    twelvefold = 12.0 * np.diag(inertia)
    for k in range(len(reference)):
        share = (k + 0.5) / len(reference)
        slope = start_slope + share * (end_slope - start_slope)
        usual = start_velocity + share * (end_velocity - start_velocity)
        force = start_force + share * (end_force - start_force) + slope * (velocity - usual)
        drag = step * slope
        steep = np.maximum(drag, 0.0)
        heavier = inertia + np.diag((0.5 + steep / (twelvefold + 2.0 * steep)) * drag)
        middle = position + 0.5 * step * velocity
        if position.size > integral.size:
            torque, weight = springs(elastic, middle, velocity, step)
            force, heavier = force + torque, heavier + weight
        error = reference[k] - turns @ velocity - by_position @ middle
        kept = kept_share * integral
        acceleration = solve(heavier + held, back @ (stiff * error + kept) - force)
        left = error - lag * (turns @ acceleration)
        torque = stiff * left + kept
        beyond = np.abs(torque) > limit
        if beyond.any():
            pull = back @ np.where(beyond, np.copysign(limit, torque), stiff * error + kept)
            free = (back * np.where(beyond, 0.0, stiff * lag)) @ turns
            acceleration = solve(heavier + free, pull - force)
            left = np.where(beyond, 0.0, error - lag * (turns @ acceleration))
        velocity = velocity + step * acceleration
        position = middle + 0.5 * step * velocity
        integral = integral + step * left
    return position, velocity, acceleration, integral


def springs(
    elastic: Elastic, position: np.ndarray, velocity: np.ndarray, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """What springs add to a step: force in its middle without acceleration (x,), and to the inertia (x, x).

    They are linear as long as no tooth lifts or lands. The position (x,) [rad] is that in the middle of the
    step [s] without acceleration, the velocity (x,) [rad/s] that at its start.
    """
    stretch, back, stiffness, damping, play = elastic
    twist = stretch @ position
    in_contact = np.abs(twist) >= play
    stiffness, damping = stiffness * in_contact, damping * in_contact
    torque = stiffness * (twist - play * np.sign(twist)) + damping * (stretch @ velocity)
    weight = 0.25 * step**2 * stiffness + 0.5 * step * damping
    return back @ torque, (back * weight) @ stretch


def torque(cascade: Cascade, reference: np.ndarray, moved: Moved) -> np.ndarray:
    """Torque (n,) [N m] of the motors at one instant, seen from their joints, by the cascade over no time."""
    turns, _, by_position, stiff, kept, _, _, limit = cascade
    position, velocity, _, integral = moved
    asked = stiff * (reference - turns @ velocity - by_position @ position) + kept * integral
    return np.minimum(np.maximum(asked, -limit), limit)


def fading(kept: float, last: np.ndarray, news: np.ndarray) -> np.ndarray:
    """What is left of news (t, n) if a share of it is kept from row to row, `last` (n,) before the first."""
    left = news.copy()
    left[0] += kept * last
    for row in range(1, len(news)):
        left[row] += kept * left[row - 1]
    return left


def solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of equations with a positive definite matrix.

    Raises:
        RobotError: It is not.
    """
    _, solution, failed = dposv(matrix, right)
    if failed:
        raise RobotError(NO_INERTIA)
    return solution


def solve_by_hand(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The same by Cholesky's decomposition, for a compiler: Python would take a hundred times as long."""
    n = len(right)
    lower, solution = np.zeros((n, n)), np.empty(n)
    for row in range(n):
        for column in range(row + 1):
            rest = matrix[row, column]
            for k in range(column):
                rest -= lower[row, k] * lower[column, k]
            if row != column:
                lower[row, column] = rest / lower[column, column]
            elif rest > 0.0:
                lower[row, row] = np.sqrt(rest)
            else:
                raise RobotError(NO_INERTIA)
        rest = right[row]
        for k in range(row):
            rest -= lower[row, k] * solution[k]
        solution[row] = rest / lower[row, row]
    for row in range(n - 1, -1, -1):
        for k in range(row + 1, n):
            solution[row] -= lower[k, row] * solution[k]
        solution[row] /= lower[row, row]
    return solution


@cache
def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """One of these functions as machine code, ten times as fast, if Numba is installed; else as it is."""
    compiler = _compiler()
    if compiler is None:
        return function
    try:
        return compiler(cache=True)(function)
    except RuntimeError:  # there is no folder to keep it in from process to process
        return compiler(function)


@cache
def _compiler() -> Callable[..., Any] | None:
    try:  # half a second, and only who simulates needs it
        from numba import njit
        from numba.extending import overload, register_jitable
    except ImportError:  # absent, or made for another NumPy
        return None
    overload(solve, strict=False)(lambda matrix, right: solve_by_hand)
    register_jitable(springs)
    return njit
