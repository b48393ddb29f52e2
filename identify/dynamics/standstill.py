"""Speed below which a joint stands, and its friction may have any value that holds it."""

import numpy as np

from ..arm.robot import Robot

SHARE_OF_LIMIT = 0.01
"""Share of the velocity limit that stands for a speed that is not known [-]; 1 % of a joint's usual speed is
also what counts as standstill when runs are prepared."""
NARROWEST = 1e-3
"""Speed of a joint without any velocity limit [rad/s]."""


def standstill(known: np.ndarray | None, robot: Robot) -> np.ndarray:
    """Speed below which each joint stands, shape (n,) [rad/s].

    Args:
        known: That of the runs of a fit; None if the fit does not state it.
        robot: The arm.
    """
    if known is not None:
        return known
    limit = robot.limits.velocity
    return np.where(np.isfinite(limit), SHARE_OF_LIMIT * limit, NARROWEST)
