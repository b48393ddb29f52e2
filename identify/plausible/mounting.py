"""Search for the direction of gravity in the base frame if the described direction does not explain a log."""

from itertools import product

import numpy as np
from scipy import optimize

from .evidence import Reading
from .mistake import with_gravity

EVALUATIONS = 40
"""Maximum number of evaluations of the search, enough for an accuracy of about one degree."""
OPPOSITE = np.radians(20.0)
"""Angle within which a direction counts as opposite to the description, as of a hanging arm."""
STEP = 0.2
"""Initial step of the search [rad]."""


def search_gravity(reading: Reading) -> np.ndarray | None:
    """Gravity in the base frame, shape (3,) [m/s^2], for which bodies explain a log best.

    None if the described direction is better than each of the directions 45 degrees apart. The diagnosis
    handles a base that is tilted by less than half of that.
    """
    described = reading.model.robot.gravity
    size = float(np.linalg.norm(described))
    if not size:
        return None
    frame = _frame(described)

    def loss(direction: np.ndarray) -> float:
        gravity = size * direction / np.linalg.norm(direction)
        other = Reading(with_gravity(reading.model, gravity), reading.log, reading.stated)
        return -other.evidence().log_likelihood

    corners = [np.array(corner, float) for corner in product((0, 1, -1), repeat=3) if any(corner)]
    others = [frame @ corner for corner in corners if tuple(corner) != (1, 0, 0)]
    start = min(others, key=loss)
    if loss(start) >= loss(described):
        return None
    start = start / np.linalg.norm(start)
    across = _frame(start)[:, 1:]
    simplex = STEP * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    options = {"maxfev": EVALUATIONS, "initial_simplex": simplex, "xatol": 1e-3, "fatol": 0.01}
    best = optimize.minimize(
        lambda lean: loss(start + across @ lean), np.zeros(2), method="Nelder-Mead", options=options
    )
    direction = start + across @ best.x
    if direction @ described < -np.cos(OPPOSITE) * size * np.linalg.norm(direction):
        return None  # this mistake has its own row in the table
    return np.asarray(size * direction / np.linalg.norm(direction))


def _frame(axis: np.ndarray) -> np.ndarray:
    """Three orthonormal columns, the first along an axis (3,)."""
    frame = np.linalg.qr(np.column_stack([axis, np.eye(3)]))[0]
    return np.asarray(frame * np.array([np.sign(frame[:, 0] @ axis), 1.0, 1.0]))
