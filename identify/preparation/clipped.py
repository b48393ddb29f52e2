"""Currents beyond what a sensor shows: which they are, and what stands for them in filters."""

import numpy as np
from scipy import ndimage

from ..arm.motion import Motion
from ..model import Model

NEAR = 0.01
"""Share of the largest current within which a sample counts as clipped [-]: noise and steps of a sensor."""


def is_clipped(model: Model, current: np.ndarray, apart: int) -> np.ndarray:
    """Whether a sensor of the model shows no more at currents (t, n) [A], bool of shape (t, n).

    Noise may take single samples below the limit: so are those between two that are at most `apart`.
    """
    at_limit = np.abs(current) >= (1.0 - NEAR) * model.current_limit
    return np.asarray(ndimage.binary_closing(at_limit, np.ones((apart, 1))) | at_limit)


def filled(
    model: Model, motion: Motion, current: np.ndarray, gain: np.ndarray, clipped: np.ndarray
) -> np.ndarray:
    """Currents (t, n) [A] with nominal ones where they are clipped, shifted to what was measured around them.

    Such samples do not count. But filters reach over them, from rows that do.
    """
    if not np.any(clipped):
        return current
    torque = np.concatenate(
        [columns @ model.nominal_values + known for columns, known in model.pieces(motion)]
    )
    nominal, values = torque @ model.robot.to_motors.T / gain, np.array(current)
    for joint in np.flatnonzero(np.any(clipped, axis=0) & ~np.all(clipped, axis=0)):
        gaps = clipped[:, joint]
        around = (current - nominal)[~gaps, joint]
        beside = np.interp(motion.time[gaps], motion.time[~gaps], around)
        values[gaps, joint] = nominal[gaps, joint] + beside
    return values
