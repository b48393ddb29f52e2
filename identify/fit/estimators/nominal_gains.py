"""Nominal gains: what their tolerance does to an estimate, and what an estimate would be if gains were known.

An estimate that takes nominal drive gains is wrong with them. Its covariance is that of values and gains
together, gains as uncertain as they are stated, so that every interval has their tolerance in it.
"""

import numpy as np

from ..equations import Equations
from .compressed import Estimate
from .covariance import Spread


def gain_deviation(equations: Equations) -> np.ndarray:
    """Standard deviation of the nominal gains, shape (n,); zero where none is stated or needed."""
    if np.all(equations.gain == 1.0):  # what counts as torque is current, or torque itself
        return np.zeros(len(equations.gain))
    return np.abs(equations.gain) * equations.gain_tolerance


def with_nominal_gains(given: np.ndarray, by_gain: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Covariance (b + n, b + n) of values, then nominal gains, of independent deviations (n,).

    Args:
        given: Covariance of the values if the gains were as stated, shape (b, b).
        by_gain: Change of each value with each gain, shape (b, n).
        deviation: Of the gains, shape (n,).
    """
    spread = np.concatenate([by_gain, np.eye(len(deviation))]) * deviation
    return np.pad(given, (0, len(deviation))) + spread @ spread.T


def of_nominal_gains(spread: Spread, equations: Equations) -> np.ndarray:
    """The same of an estimate of values (b,) in torque, of which `spread` is by measured torque."""
    return with_nominal_gains(spread.covariance, spread.by_scale / equations.gain, gain_deviation(equations))


def given_nominal(estimate: Estimate) -> np.ndarray:
    """Covariance (b, b) of the values: if the gains were as stated, where they are nominal."""
    return given_gains(estimate, np.full(len(estimate.gain), estimate.nominal_gains))


def given_gains(estimate: Estimate, which: np.ndarray) -> np.ndarray:
    """Covariance of the base values if some gains, bool of shape (n,), were known, shape (b, b)."""
    count = len(estimate.values)
    whole = estimate.covariance[:count, :count]
    if not np.any(which & (estimate.gain_std > 0.0)):
        return np.array(whole)
    by_gain = slope(estimate, which)
    given = whole - by_gain @ estimate.covariance[count:, count:] @ by_gain.T
    given = 0.5 * (given + given.T)
    given[np.diag_indices(count)] = np.maximum(np.diag(given), np.finfo(float).eps * np.diag(whole))
    return given


def slope(estimate: Estimate, which: np.ndarray | None = None) -> np.ndarray:
    """Change of each base value with each gain, or with some of them, shape (b, n).

    It is zero for a gain that has no deviation.
    """
    count, std = len(estimate.values), estimate.gain_std
    change = np.zeros((count, len(std)))
    uncertain = std > 0.0 if which is None else (std > 0.0) & which
    if (known := np.flatnonzero(uncertain)).size:
        both = estimate.covariance[:count, count + known] / std[known]
        gains = estimate.covariance[np.ix_(count + known, count + known)]
        correlation = gains / np.outer(std[known], std[known])
        change[:, known] = np.linalg.lstsq(correlation, both.T, rcond=None)[0].T / std[known]
    return change
