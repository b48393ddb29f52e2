"""Where two arms, or one arm on two days, differ."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy import stats

from ..positive_definite import covariance, factored, inverse, solve
from .learned import Learned
from .runs import ArmRuns

WRONG = 0.05
"""Probability that two equal arms are said to differ in anything at all."""
PAIRS = 200
"""Pairs of successive runs by which that is checked: their 95 % is then exceeded by ten."""
FEWEST = 20
"""The same at least: one in twenty exceeds 95 %."""
SAME = 1e-9
"""Share of a direction that is left where the chosen ones make it up, but for rounding."""


class Difference(NamedTuple):
    """What differs.

    Attributes:
        effect: In the vocabulary of the diagnosis.
        joint: From 0; -1 for a combination of links.
        parameter: Its name.
        unit: Unit of the amounts; empty where they are shares.
        first: Value of the first arm; NaN where there is none.
        amount: Second minus first.
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
    """What differs, the most certain first, as long as equal arms would not show it.

    Each arm's values have the scatter from run to run in their covariance, and what temperature leaves open.
    """
    frame, size = learned.frame, len(learned.frame.scale)
    one, apart, precision = _apart(learned, first, second)
    labels, directions = _asked(learned)
    chosen: list[int] = []
    while len(chosen) < len(labels):
        left = apart - _explained(directions[chosen], precision, apart) if chosen else apart
        deviations = _deviations(directions, chosen, precision, left)
        if np.max(deviations) < threshold_of(learned):
            break
        chosen.append(int(np.argmax(deviations)))
    if not chosen:
        return []
    factor = factored(directions[chosen] @ precision @ directions[chosen].T)
    amounts = solve(factor, directions[chosen] @ precision @ apart)
    stds = np.sqrt(np.diag(covariance(factor)))
    values = one[:size] * frame.scale
    rows = [
        Difference(*labels[k][:4], values[labels[k][4]] if labels[k][4] >= 0 else np.nan, float(a), float(s))
        for k, a, s in zip(chosen, amounts, stds, strict=True)
    ]
    return sorted(rows, key=lambda row: -abs(row.amount) / row.std)


@lru_cache(maxsize=8)
def threshold_of(learned: Learned) -> float:
    """Deviations that the surest of all parameters exceeds with `WRONG` though arms are equal.

    By Bonferroni; or what successive runs of one arm show, if that is more: what a model leaves is not noise.
    """
    _, directions = _asked(learned)
    by_chance = float(stats.norm.isf(0.5 * WRONG / len(directions)))
    places = [(runs, k) for runs in learned.arms.values() for k in range(len(runs.runs) - 1)]
    tops = []
    for runs, k in places[:: max(len(places) // PAIRS, 1)]:
        _, apart, precision = _apart(learned, runs[k : k + 1], runs[k + 1 : k + 2])
        tops.append(float(np.max(_deviations(directions, [], precision, apart))))
    return max(by_chance, float(np.quantile(tops, 1.0 - WRONG))) if len(tops) >= FEWEST else by_chance


def _apart(learned: Learned, first: ArmRuns, second: ArmRuns) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unknowns of the first arm (d,), what the second adds (m,), and the precision of that (m, m)."""
    size = len(learned.frame.scale)
    (one, one_covariance), (other, other_covariance) = (learned.level(runs) for runs in (first, second))
    return one, (other - one)[:size], inverse((one_covariance + other_covariance)[:size, :size])


def _asked(learned: Learned) -> tuple[list[tuple[str, int, str, str, int]], np.ndarray]:
    """Causes; each direction in the frame's units for an amount of one."""
    frame = learned.frame
    labels = [(c.effect, c.joint, c.parameter, c.unit, c.place) for c in frame.causes]
    return labels, frame.directions


def _explained(directions: np.ndarray, precision: np.ndarray, apart: np.ndarray) -> np.ndarray:
    along = directions @ precision
    return directions.T @ np.linalg.solve(along @ directions.T, along @ apart)


def _deviations(
    directions: np.ndarray, chosen: list[int], precision: np.ndarray, left: np.ndarray
) -> np.ndarray:
    """Standard deviations of each direction in what is left, the chosen ones free, shape (k,)."""
    weighted = directions @ precision
    whole = np.einsum("km,km->k", weighted, directions)
    own = whole
    if chosen:
        across = weighted[chosen] @ directions.T
        own = own - np.einsum("ck,ck->k", across, np.linalg.solve(across[:, chosen], across))
    free = own > SAME * whole
    free[chosen] = False
    return np.where(free, np.abs(weighted @ left) / np.sqrt(np.where(free, own, 1.0)), 0.0)
