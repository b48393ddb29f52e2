"""Essential parameters: those the data do not support are dropped stepwise."""

import numpy as np
from scipy import stats

from .estimators import Estimate

CONFIDENCE = 0.95
"""Dropped parameters are together zero as far as the data can say: their joint Wald statistic stays
below this quantile of chi-squared."""


def unsupported(estimate: Estimate) -> list[int]:
    """Base parameters that may be zero, in the order in which they were dropped.

    At each step the one with the smallest ratio of value to deviation goes, and the others take their
    conditional values given that it is zero.
    """
    count = len(estimate.values)
    values = np.array(estimate.values)
    covariance = np.array(estimate.covariance[:count, :count])
    left, dropped, statistic = list(range(count)), [], 0.0
    while len(left) > 1:
        deviation = np.sqrt(np.diag(covariance)[left])
        ratio = np.abs(values[left]) / np.maximum(deviation, np.finfo(float).tiny)
        weakest = left[int(np.argmin(ratio))]
        statistic += float(np.min(ratio)) ** 2
        if statistic > stats.chi2.ppf(CONFIDENCE, len(dropped) + 1):
            break
        step = covariance[:, weakest] / covariance[weakest, weakest]
        values -= step * values[weakest]
        covariance -= np.outer(step, covariance[weakest])
        dropped.append(weakest)
        left.remove(weakest)
    return dropped
