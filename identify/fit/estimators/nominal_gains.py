"""Effect of the tolerance of nominal drive gains on an estimate, and the covariance at known gains.

Errors of nominal drive gains are errors of the estimate. Its covariance is therefore that of values and gains
together, with the stated tolerance of the gains, so that every interval includes that tolerance.
"""

import numpy as np

from ..equations import Equations
from .compressed import Estimate


def gain_deviation(equations: Equations) -> np.ndarray:
    """Standard deviation of the nominal gains, shape (n,); zero if gains are not stated or not needed."""
    if np.all(equations.gain == 1.0):  # torque was recorded, or currents without stated gains
        return np.zeros(len(equations.gain))
    return np.abs(equations.gain) * equations.gain_tolerance


def with_nominal_gains(covariance: np.ndarray, by_gain: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Covariance (b + n, b + n) of values, then nominal gains with independent errors.

    Args:
        covariance: Covariance of the values at exact gains, shape (b, b).
        by_gain: Change of each value with each gain, shape (b, n).
        deviation: Standard deviation of each gain, shape (n,).
    """
    spread = np.concatenate([by_gain, np.eye(len(deviation))]) * deviation
    return np.pad(covariance, (0, len(deviation))) + spread @ spread.T


def given_nominal(estimate: Estimate) -> np.ndarray:
    """Covariance (b, b) of the values; nominal gains, if the estimate uses them, count as exact."""
    return given_gains(estimate, np.full(len(estimate.gain), estimate.nominal_gains))


def given_gains(estimate: Estimate, exact: np.ndarray) -> np.ndarray:
    """Covariance (b, b) of the base values if the gains selected by `exact`, shape (n,), were known."""
    count = len(estimate.values)
    marginal = estimate.covariance[:count, :count]
    if not np.any(exact & (estimate.gain_std > 0.0)):
        return np.array(marginal)
    by_gain = slope(estimate, exact)
    conditional = marginal - by_gain @ estimate.covariance[count:, count:] @ by_gain.T
    conditional = 0.5 * (conditional + conditional.T)
    floor = np.finfo(float).eps * np.diag(marginal)
    conditional[np.diag_indices(count)] = np.maximum(np.diag(conditional), floor)
    return conditional


def slope(estimate: Estimate, selected: np.ndarray | None = None) -> np.ndarray:
    """Change of each base value with each gain, or with the selected gains, shape (b, n).

    The change is zero for gains without uncertainty.
    """
    count, std = len(estimate.values), estimate.gain_std
    change = np.zeros((count, len(std)))
    uncertain = std > 0.0 if selected is None else (std > 0.0) & selected
    if (known := np.flatnonzero(uncertain)).size:
        scaled = estimate.covariance[:count, count + known] / std[known]
        gains = estimate.covariance[np.ix_(count + known, count + known)]
        correlation = gains / np.outer(std[known], std[known])
        change[:, known] = np.linalg.lstsq(correlation, scaled.T, rcond=None)[0].T / std[known]
    return change
