"""Steps: the inner loop of the plant, of numbers and arrays only, so that it can be compiled.

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

NO_INERTIA = (
    "the simulated arm has directions without inertia, in which it cannot move; give every joint a rotor "
    "inertia, and every link a mass"
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
        limit: Of the motors' torque, shape (n,) [N m].
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
    """Forces at one end of some steps, linear in velocity around it; each of shape (x,)."""

    force: np.ndarray
    slope: np.ndarray
    velocity: np.ndarray


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
    position, velocity, acceleration, integral = moved
    own = np.diag(inertia)
    for k in range(len(reference)):
        share = (k + 0.5) / len(reference)
        slope = start.slope + share * (end.slope - start.slope)
        usual = start.velocity + share * (end.velocity - start.velocity)
        force = start.force + share * (end.force - start.force) + slope * (velocity - usual)
        drag = step * slope
        steep = np.maximum(drag, 0.0)
        heavier = inertia + np.diag((0.5 + steep / (12.0 * own + 2.0 * steep)) * drag)
        middle = position + 0.5 * step * velocity
        if len(elastic.stiffness) > 0:
            torque, weight = springs(elastic, middle, velocity, step)
            force, heavier = force + torque, heavier + weight
        error = reference[k] - cascade.turns @ velocity - cascade.by_position @ middle
        kept = cascade.kept * integral
        pull = cascade.back @ (cascade.stiff * error + kept)
        acceleration = solve(heavier + cascade.held, pull - force)
        left = error - cascade.lag * (cascade.turns @ acceleration)
        torque = cascade.stiff * left + kept
        beyond = np.abs(torque) > cascade.limit
        if beyond.any():
            limit = np.copysign(cascade.limit, torque)
            stiff = np.where(beyond, 0.0, cascade.stiff)
            pull = cascade.back @ np.where(beyond, limit, cascade.stiff * error + kept)
            held = (cascade.back * (stiff * cascade.lag)) @ cascade.turns
            acceleration = solve(heavier + held, pull - force)
            left = np.where(beyond, 0.0, error - cascade.lag * (cascade.turns @ acceleration))
        position = middle + 0.5 * step * (velocity + step * acceleration)
        velocity = velocity + step * acceleration
        integral = integral + step * left
    return position, velocity, acceleration, integral


def springs(
    elastic: Elastic, position: np.ndarray, velocity: np.ndarray, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """What springs add to a step: force in its middle without acceleration (x,), and to the inertia (x, x).

    They are linear as long as no tooth lifts or lands.

    Args:
        elastic: What they are.
        position: In the middle of the step without acceleration, shape (x,) [rad].
        velocity: At its start, shape (x,) [rad/s].
        step: [s].
    """
    twist = elastic.stretch @ position
    touching = np.abs(twist) >= elastic.play
    stiffness, damping = elastic.stiffness * touching, elastic.damping * touching
    torque = stiffness * (twist - elastic.play * np.sign(twist)) + damping * (elastic.stretch @ velocity)
    weight = 0.25 * step**2 * stiffness + 0.5 * step * damping
    return elastic.back @ torque, (elastic.back * weight) @ elastic.stretch


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
