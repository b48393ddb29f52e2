"""Mistakes whose size is found by a search: the direction of gravity in the base frame, and another clock."""

from collections.abc import Callable
from itertools import product

import numpy as np
from scipy import optimize

from .change import Change
from .evidence import Reading

EVALUATIONS = 40
"""Maximum number of evaluations of a search, enough for an accuracy of about one degree."""
OPPOSITE = np.radians(20.0)
"""Angle within which a direction counts as opposite to the description, as of a hanging arm."""
STEP = 0.2
"""Initial step of the search for gravity [rad]."""
LATE = 0.05
"""Initial step of a delay at the beginning and at the end of a log [s]."""
LATEST = 1.0
"""Largest delay [s]: a larger one is no delay but another run."""
CERTAIN = 10.0
"""Gain in log-likelihood over a constant delay from which on a delay changes, as for other motions."""
DRIFTS = 0.02
"""Least change of a delay over a log [s]: two clocks that differ by less do no harm below 5 Hz."""


def search_gravity(reading: Reading) -> np.ndarray | None:
    """Gravity in the base frame, shape (3,) [m/s^2], for which bodies explain a log best.

    None if the described direction is better than each of the directions 45 degrees apart. The diagnosis
    handles a base that is tilted by less than half of that.
    """
    described = reading.model.robot.gravity
    size = float(np.linalg.norm(described))
    if not size or reading.log.moving.sum() < 2:
        return None
    frame = _frame(described)

    def changed(direction: np.ndarray) -> Reading:
        return reading.changed(Change(gravity=size * direction / np.linalg.norm(direction)))

    def loss(direction: np.ndarray) -> float:
        return -changed(direction).quick

    # Bodies of any mass, also negative, fit in opposite directions alike.
    corners = [np.array(corner, float) for corner in product((0, 1, -1), repeat=3) if any(corner)]
    half = [frame @ corner for corner in corners if tuple(corner) > (0, 0, 0) and tuple(corner) != (1, 0, 0)]
    start = min(half, key=loss)
    if loss(start) >= loss(described):
        return None
    start = start / np.linalg.norm(start)
    across = _frame(start)[:, 1:]
    lean = _least(lambda lean: loss(start + across @ lean), STEP)
    direction = start + across @ lean
    direction = max((direction, -direction), key=lambda one: changed(one).evidence.log_likelihood)
    direction /= np.linalg.norm(direction)
    if direction @ described < -np.cos(OPPOSITE) * size:
        return None  # this mistake has its own row in the table
    return np.asarray(size * direction)


def search_clocks(reading: Reading) -> tuple[float, float] | None:
    """Delay of the efforts at the first sample [s] and its increase [s/s] for which bodies explain it best.

    None if the delay does not certainly change, or if the log has several runs.
    """
    time = reading.log.motion.time
    if len(time) < 2 or np.any(np.diff(time) <= 0.0):
        return None
    length = float(time[-1] - time[0])

    def loss(ends: np.ndarray) -> float:
        if np.abs(ends).max() > LATEST:
            return np.inf
        return -reading.changed(Change(late=(ends[0], (ends[1] - ends[0]) / length))).quick

    first, last = ends = _least(loss, LATE)
    # A delay that stays the same is for the diagnosis.
    constant = loss(np.full(2, ends.mean())) - loss(ends) < CERTAIN
    return None if constant or abs(last - first) < DRIFTS else (first, (last - first) / length)


def _least(loss: Callable[[np.ndarray], float], step: float) -> np.ndarray:
    """Two numbers near zero with the least loss."""
    simplex = step * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    options = {"maxfev": EVALUATIONS, "initial_simplex": simplex, "xatol": 1e-3, "fatol": 0.01}
    return np.asarray(optimize.minimize(loss, np.zeros(2), method="Nelder-Mead", options=options).x)


def _frame(axis: np.ndarray) -> np.ndarray:
    """Three orthonormal columns, the first along an axis (3,)."""
    frame = np.linalg.qr(np.column_stack([axis, np.eye(3)]))[0]
    return np.asarray(frame * np.array([np.sign(frame[:, 0] @ axis), 1.0, 1.0]))
