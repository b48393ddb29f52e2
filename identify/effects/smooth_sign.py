"""Sign of a velocity, smooth around zero so that it can be fitted and filtered."""

import numpy as np

REVERSAL = 0.003
"""Velocity over which dry friction changes its sign, unless a recording shows another one [rad/s]."""


def smooth_sign(velocity: np.ndarray, reversal: float = REVERSAL) -> np.ndarray:
    """Direction of motion, from -1 to 1: tanh(velocity / reversal), both [rad/s]."""
    return np.tanh(velocity / reversal)


def smooth_sign_by_velocity(velocity: np.ndarray, reversal: float) -> np.ndarray:
    """Derivative of `smooth_sign` with respect to the velocity [s/rad]."""
    # cosh overflows above 710; at 300 the slope is already 1e-260.
    return 1.0 / reversal / np.cosh(np.clip(velocity / reversal, -300, 300)) ** 2


def smooth_sign_by_reversal(velocity: np.ndarray, reversal: float) -> np.ndarray:
    """Derivative of `smooth_sign` with respect to the reversal velocity [s/rad]."""
    return -velocity / reversal * smooth_sign_by_velocity(velocity, reversal)
