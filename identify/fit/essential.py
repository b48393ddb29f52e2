"""Essential parameters: those the data do not support are dropped stepwise."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from scipy import stats

from .estimators import Estimate
from .settled_gains import OPEN, given_gains

CONFIDENCE = 0.95
"""Dropped parameters are together zero as far as the data show: their joint Wald statistic stays
below this quantile of chi-squared."""


def unsupported(estimate: Estimate, held: Collection[int] = ()) -> list[int]:
    """Base parameters that may be zero, in the order in which they were dropped.

    At each step the one with the smallest ratio of value to deviation goes, and the others take their
    conditional values given that it is zero.

    Args:
        estimate: With all base parameters.
        held: Those whose prior is far from zero: runs that cannot see one are no reason to set
            it to zero, and what it is confounded with would take its place.
    """
    count = len(estimate.values)
    values = np.array(estimate.values)
    # What may be larger or smaller with an open gain is not zero for that.
    covariance = given_gains(estimate, estimate.gain_std > OPEN * np.abs(estimate.gain))
    left, statistic = [k for k in range(count) if k not in held], 0.0
    dropped: list[int] = []
    while len(left) > (0 if held else 1):
        variance = np.diag(covariance)[left]  # rounding may leave one slightly negative
        ratio = np.abs(values[left]) / np.sqrt(np.maximum(variance, np.finfo(float).tiny))
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


def as_uncertain(reduced: Estimate, whole: Estimate, dropped: Sequence[int]) -> Estimate:
    """The estimate without some parameters, as uncertain as with them.

    The data do not show that what was dropped is zero, only that it may be: it is zero up to its deviation,
    and what it is correlated with is off by its share. By block inversion that adds up to the covariance
    that the others had before.
    """
    left = np.delete(np.arange(len(whole.covariance)), list(dropped))
    return replace(reduced, covariance=whole.covariance[np.ix_(left, left)])
