"""Clipped currents, beyond the range of a sensor: their detection, and their replacement in filters."""

import numpy as np
from scipy import ndimage

from ..arm.motion import Motion
from ..model import Model

NEAR = 0.01
"""Distance from the largest current within which a sample counts as clipped, as a share of it [-]; it allows
for noise and quantization."""


def is_clipped(model: Model, current: np.ndarray, apart: int) -> np.ndarray:
    """Whether currents (t, n) [A] are at the limit of a sensor in the model, bool of shape (t, n).

    Noise may take single samples below the limit, so gaps of less than `apart` samples count as clipped.
    """
    at_limit = np.abs(current) >= (1.0 - NEAR) * model.current_limit
    return np.asarray(ndimage.binary_closing(at_limit, np.ones((apart, 1))) | at_limit)


def filled(
    model: Model, motion: Motion, current: np.ndarray, gain: np.ndarray, clipped: np.ndarray
) -> np.ndarray:
    """Currents (t, n) [A] in which clipped samples are nominal currents, shifted to match their neighbors.

    Clipped samples have no weight, but the filters of samples with weight extend over them.
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
        shift = np.interp(motion.time[gaps], motion.time[~gaps], around)
        values[gaps, joint] = nominal[gaps, joint] + shift
    return values
