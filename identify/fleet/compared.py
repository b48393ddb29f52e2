"""Differences between two arms, or between two days of one arm."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy import stats

from ..positive_definite import covariance, factored, inverse, solve
from .learned import Learned
from .runs import ArmRuns

WRONG = 0.05
"""Probability of reporting any difference between two equal arms."""
PAIRS = 200
"""Maximum number of pairs of successive runs that check this: ten of them exceed the 95 % quantile."""
FEWEST = 20
"""Minimum number of such pairs: one of them exceeds the 95 % quantile."""
SAME = 1e-9
"""Remaining share of a direction below which it counts as a combination of the chosen ones."""


class Difference(NamedTuple):
    """Difference of two arms in one parameter.

    Attributes:
        effect: Name of the effect in the vocabulary of the diagnosis.
        joint: Index of the joint, from 0; -1 for a combination of links.
        parameter: Name of the parameter.
        unit: Unit of the amount; empty if it is a share.
        first: Value of the first arm; NaN if there is none.
        amount: Second value minus first value.
        std: Standard deviation of the amount.
    """

    effect: str
    joint: int
    parameter: str
    unit: str
    first: float
    amount: float
    std: float


def compared(learned: Learned, first: ArmRuns, second: ArmRuns) -> list[Difference]:
    """Significant differences, the most certain first.

    The covariance of each arm's values includes the scatter from run to run and the uncertainty of
    temperature effects.
    """
    frame, size = learned.frame, len(learned.frame.scale)
    first_level, difference, precision = _difference(learned, first, second)
    directions = frame.directions
    chosen: list[int] = []
    while len(chosen) < len(directions):
        residual = (
            difference - _explained(directions[chosen], precision, difference) if chosen else difference
        )
        deviations = _deviations(directions, chosen, precision, residual)
        if np.max(deviations) < threshold_of(learned):
            break
        chosen.append(int(np.argmax(deviations)))
    if not chosen:
        return []
    factor = factored(directions[chosen] @ precision @ directions[chosen].T)
    amounts = solve(factor, directions[chosen] @ precision @ difference)
    stds = np.sqrt(np.diag(covariance(factor)))
    values = first_level[:size] * frame.scale
    rows = []
    for cause, amount, std in zip([frame.causes[k] for k in chosen], amounts, stds, strict=True):
        usual = values[cause.place] if cause.place >= 0 else np.nan
        what = cause.effect, cause.joint, cause.parameter, cause.unit
        rows.append(Difference(*what, usual, float(amount), float(std)))
    return sorted(rows, key=lambda row: -abs(row.amount) / row.std)


@lru_cache(maxsize=8)
def threshold_of(learned: Learned) -> float:
    """Number of standard deviations that any parameter of two equal arms exceeds with probability `WRONG`.

    It follows from Bonferroni's bound, or from successive runs of one arm if they differ more, because model
    errors are not noise.
    """
    directions = learned.frame.directions
    by_chance = float(stats.norm.isf(0.5 * WRONG / len(directions)))
    pairs = [(runs, k) for runs in learned.arms.values() for k in range(len(runs.runs) - 1)]
    maxima = []
    for runs, k in pairs[:: max(len(pairs) // PAIRS, 1)]:
        _, difference, precision = _difference(learned, runs[k : k + 1], runs[k + 1 : k + 2])
        maxima.append(float(np.max(_deviations(directions, [], precision, difference))))
    return max(by_chance, float(np.quantile(maxima, 1.0 - WRONG))) if len(maxima) >= FEWEST else by_chance


def _difference(
    learned: Learned, first: ArmRuns, second: ArmRuns
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unknowns of the first arm (d,), difference to the second (m,), and the precision of that (m, m)."""
    size = len(learned.frame.scale)
    (first_level, first_covariance), (second_level, second_covariance) = (
        learned.level(runs) for runs in (first, second)
    )
    precision = inverse((first_covariance + second_covariance)[:size, :size])
    return first_level, (second_level - first_level)[:size], precision


def _explained(directions: np.ndarray, precision: np.ndarray, difference: np.ndarray) -> np.ndarray:
    weighted = directions @ precision
    return directions.T @ np.linalg.solve(weighted @ directions.T, weighted @ difference)


def _deviations(
    directions: np.ndarray, chosen: list[int], precision: np.ndarray, residual: np.ndarray
) -> np.ndarray:
    """Size of the residual along each direction in standard deviations, with the chosen free, shape (k,)."""
    weighted = directions @ precision
    total = np.einsum("km,km->k", weighted, directions)
    remaining = total
    if chosen:
        across = weighted[chosen] @ directions.T
        remaining = remaining - np.einsum("ck,ck->k", across, np.linalg.solve(across[:, chosen], across))
    free = remaining > SAME * total
    free[chosen] = False
    return np.where(free, np.abs(weighted @ residual) / np.sqrt(np.where(free, remaining, 1.0)), 0.0)
