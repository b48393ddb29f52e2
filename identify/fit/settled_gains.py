"""Open drive gains: gains that the runs do not determine, dependent values, and how to settle both.

A payload on the axis of a joint causes no torque there. The current of that joint then determines only the
ratios of inertia, friction and gain: all of them may be larger by the same factor. Another gain therefore
requires the base values that belong to it.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import stats

from ..arm.robot import Robot
from ..positive_definite import factored, solve
from .estimators import Estimate
from .estimators.least_squares import given_gains, slope
from .fit import Fit

OPEN = 0.3
"""Relative standard deviation beyond which a gain counts as open, as for parameters."""
MAINLY = 0.5
"""A value is open because of a gain if this share of its variance is from that gain."""


class Settled(NamedTuple):
    """Drive gains and the base values that belong to them."""

    # Gains of the fit, combined with nominal gains where the runs leave them open, shape (n,).
    gain: np.ndarray
    gain_covariance: np.ndarray  # covariance of the gains, shape (n, n)
    values: np.ndarray  # base parameters at these gains, shape (b,)
    conditional: np.ndarray  # covariance of the values at exactly known gains, shape (b, b)
    by_gain: np.ndarray  # change of each value with each gain, shape (b, n)


def stated(robot: Robot) -> bool:
    """Whether the robot description has drive gains."""
    return not np.all(robot.drive_gain == 1.0)


def open_gains(estimate: Estimate, robot: Robot) -> np.ndarray:
    """Whether each gain was estimated but remains open, shape (n,): less certain than the stated gain."""
    limit = OPEN * np.abs(estimate.gain)
    if stated(robot):
        limit = np.minimum(limit, robot.drive_gain_tolerance * np.abs(robot.drive_gain))
    return estimate.gain_estimated & (estimate.gain_std > limit)


def settled(fit: Fit) -> Settled:
    """Gains of the fit, open ones combined with nominal values, and the base values that belong to them."""
    estimate, robot = fit.estimate, fit.model.robot
    count, gain = len(estimate.values), estimate.gain
    covariance = estimate.covariance[count:, count:]
    by_gain, conditional = slope(estimate), given_gains(estimate, estimate.gain_std > 0.0)
    free = open_gains(estimate, robot)
    if np.any(free) and stated(robot):
        # The nominal values of the other gains are not used: the runs determine them.
        std = robot.drive_gain_tolerance * np.abs(robot.drive_gain)
        gain, covariance = _with_nominal(gain, covariance, robot.drive_gain, std, free)
    values = estimate.values + by_gain @ (gain - estimate.gain)
    return Settled(gain, covariance, values, conditional, by_gain)


def open_by_gain(estimate: Estimate, robot: Robot) -> dict[int, int]:
    """Base parameters whose uncertainty is mainly that of an open or nominal gain: index -> its joint."""
    uncertain = estimate.gain_std > 0.0
    free = np.flatnonzero(uncertain if estimate.nominal_gains else open_gains(estimate, robot))
    variance = np.diag(estimate.covariance)[: len(estimate.values)]
    if not free.size:
        return {}
    by_gain = (slope(estimate)[:, free] * estimate.gain_std[free]) ** 2
    return {
        int(row): int(free[np.argmax(by_gain[row])])
        for row in np.flatnonzero(by_gain.max(axis=1) > MAINLY * variance)
    }


def cure(robot: Robot, joint: int) -> str:
    """Words for the run that would determine the open gain of a joint."""
    name = robot.joints[joint]
    if robot.revolute[joint]:
        return f"a run with a known payload that hangs off the axis of {name}"
    return f"a run with a known payload in which {name} accelerates hard"


def _with_nominal(
    gain: np.ndarray, covariance: np.ndarray, nominal: np.ndarray, std: np.ndarray, selected: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gains (n,) and their covariance (n, n), updated with the nominal values of the selected gains."""
    rows = np.eye(len(gain))[selected]
    total = covariance[np.ix_(selected, selected)] + np.diag(std[selected] ** 2)
    share = solve(factored(total), rows @ covariance).T
    keep = np.eye(len(gain)) - share @ rows
    after = keep @ covariance @ keep.T + share @ np.diag(std[selected] ** 2) @ share.T
    return gain + share @ (nominal - gain)[selected], after


CONFIDENCE = 0.95
"""Dropped parameters are jointly indistinguishable from zero: their Wald statistic stays below this quantile
of chi-squared."""


def unsupported(estimate: Estimate, held: Collection[int] = ()) -> list[int]:
    """Base parameters that are indistinguishable from zero, in the order in which they are dropped.

    Each step drops the parameter with the smallest ratio of value to standard deviation and conditions the
    others on its value being zero.

    Args:
        estimate: Estimate of all base parameters.
        held: Indices of parameters whose prior is far from zero. They are not dropped: if the runs do not
            show them, parameters that are confounded with them would absorb their torque.
    """
    count = len(estimate.values)
    values = np.array(estimate.values)
    # The scale uncertainty from an open or nominal gain does not make a value indistinguishable from zero.
    loose = estimate.gain_std > OPEN * np.abs(estimate.gain)
    covariance = given_gains(estimate, loose | estimate.nominal_gains)
    candidates, statistic = [k for k in range(count) if k not in held], 0.0
    dropped: list[int] = []
    while len(candidates) > (0 if held else 1):
        variance = np.diag(covariance)[candidates]  # rounding may make a variance slightly negative
        ratio = np.abs(values[candidates]) / np.sqrt(np.maximum(variance, np.finfo(float).tiny))
        weakest = candidates[int(np.argmin(ratio))]
        statistic += float(np.min(ratio)) ** 2
        if statistic > stats.chi2.ppf(CONFIDENCE, len(dropped) + 1):
            break
        step = covariance[:, weakest] / covariance[weakest, weakest]
        values -= step * values[weakest]
        covariance -= np.outer(step, covariance[weakest])
        dropped.append(weakest)
        candidates.remove(weakest)
    return dropped


def as_uncertain(reduced: Estimate, full: Estimate, dropped: Sequence[int]) -> Estimate:
    """Estimate without the dropped parameters, with the covariance of the estimate that includes them.

    The data do not show that a dropped parameter is zero, only that it may be: its standard deviation remains
    and affects all correlated parameters. By block inversion, this gives the covariance that the other
    parameters had before.
    """
    remaining = np.delete(np.arange(len(full.covariance)), list(dropped))
    return replace(reduced, covariance=full.covariance[np.ix_(remaining, remaining)])
