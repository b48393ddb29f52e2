"""Settled gains: which drive gains runs leave open, what depends on them, and values that go together.

Of a payload on the axis of a joint nothing is felt there. What current its drive needs then says how inertia,
friction and gain are related, and not how large any of them is: all may be larger by the same share. Whoever
takes another gain must take the values that go with it.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import stats

from ..arm.robot import Robot
from ..positive_definite import factored, solve
from .estimators import Estimate
from .estimators.nominal_gains import given_gains, slope
from .fit import Fit

OPEN = 0.3
"""Deviation over value from which a gain is open, as a parameter is."""
MAINLY = 0.5
"""Share of a variance that comes from gains from which a value is open because of them."""


class Settled(NamedTuple):
    """Drive gains and values that go together.

    Attributes:
        gain: Those of the fit; where the runs leave them open, with what is nominal, shape (n,).
        gain_covariance: Shape (n, n).
        values: Base parameters at these gains, shape (b,).
        given: Their covariance if the gains were known, shape (b, b).
        by_gain: Change of each value with each gain, shape (b, n).
    """

    gain: np.ndarray
    gain_covariance: np.ndarray
    values: np.ndarray
    given: np.ndarray
    by_gain: np.ndarray


def stated(robot: Robot) -> bool:
    """Whether the robot's description has drive gains."""
    return not np.all(robot.drive_gain == 1.0)


def open_gains(estimate: Estimate, robot: Robot) -> np.ndarray:
    """Whether each gain was estimated and remains open, shape (n,): the runs show less than is stated."""
    limit = OPEN * np.abs(estimate.gain)
    if stated(robot):
        limit = np.minimum(limit, robot.drive_gain_tolerance * np.abs(robot.drive_gain))
    return estimate.gain_estimated & (estimate.gain_std > limit)


def settled(fit: Fit) -> Settled:
    """The fit's gains, those that are open settled by what is nominal, and the values that go with them."""
    estimate, robot = fit.estimate, fit.model.robot
    count, gain = len(estimate.values), estimate.gain
    covariance = estimate.covariance[count:, count:]
    by_gain, given = slope(estimate), given_gains(estimate, estimate.gain_std > 0.0)
    free = open_gains(estimate, robot)
    if np.any(free) and stated(robot):
        # Of the others nothing nominal is taken: they stay what the runs say.
        std = robot.drive_gain_tolerance * np.abs(robot.drive_gain)
        gain, covariance = _with_nominal(gain, covariance, robot.drive_gain, std, free)
    values = estimate.values + by_gain @ (gain - estimate.gain)
    return Settled(gain, covariance, values, given, by_gain)


def open_by_gain(estimate: Estimate, robot: Robot) -> dict[int, int]:
    """Base parameters that are as uncertain as they are because a gain is open or nominal: place -> joint."""
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
    """Which run would settle the open gain of a joint."""
    name = robot.joints[joint]
    if robot.revolute[joint]:
        return f"a run with a known payload that hangs off the axis of {name}"
    return f"a run with a known payload in which {name} accelerates hard"


def _with_nominal(
    gain: np.ndarray, covariance: np.ndarray, nominal: np.ndarray, std: np.ndarray, seen: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gains (n,) and their covariance (n, n) with nominal values of some."""
    rows = np.eye(len(gain))[seen]
    total = covariance[np.ix_(seen, seen)] + np.diag(std[seen] ** 2)
    share = solve(factored(total), rows @ covariance).T
    keep = np.eye(len(gain)) - share @ rows
    after = keep @ covariance @ keep.T + share @ np.diag(std[seen] ** 2) @ share.T
    return gain + share @ (nominal - gain)[seen], after


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
    # What may be larger or smaller with an open or nominal gain is not zero for that.
    loose = estimate.gain_std > OPEN * np.abs(estimate.gain)
    covariance = given_gains(estimate, loose | estimate.nominal_gains)
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
