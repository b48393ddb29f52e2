"""Scatter: the variance between runs of a type of arm, how much it differs between arms, and its tails.

It is learned from the deviations of runs after all changes of their arms have been explained.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import special, stats

TAILS = (2.0, 2.5, 3.0, 4.0, 6.0, 10.0, 20.0, 50.0)
"""Degrees of freedom of Student's distribution to try: from infinite variance to nearly normal."""
FIRST_TAILS = 4.0
"""Degrees of freedom before the scatter is known."""
TOLD_APART = 2.0
"""Difference of log-likelihoods up to which heavier tails are preferred: odds of seven."""
ARMS_DIFFER = 2.0
"""Initial weight of the type's scatter against that of an arm, in runs: one in ten arms then scatters by more
than three times that of its type, or by less than a third."""
ALIKE = 40.0
"""Maximum of that weight: the standard deviations of arms are never known to agree better than to a sixth."""
FEW_ARMS = 3
"""Weight of the same effect on other joints, in arms; also the minimum number of arms to compare."""
SHOWN = 0.5
"""Minimum share of a deviation that runs determine for it to count: the rest is prior."""
ODD = 5.0
"""Median of squared deviations over their variance from which a whole run is an outlier."""
ROUNDS = 30
"""Iterations between scales and weights."""
RARE = 0.01
"""Probability of the quantile at which tails are checked."""
LEAST_SEEN = 500
"""Minimum number of deviations for this check: five are then expected beyond the quantile."""
BY_CHANCE = 1e-3
"""Probability of rejecting correct tails as too light."""


class Scatter(NamedTuple):
    """Scatter of the runs of a type.

    Attributes:
        variance: Variance of each unknown relative to that from successive runs, shape (m,).
        alike: Weight of this variance against that of an arm, in runs, shape (m,).
        tails: Degrees of freedom of Student's distribution.
        seen: Number of deviations from which these are known.
        beyond: Number of deviations beyond the limit that one in a hundred should exceed.
    """

    variance: np.ndarray
    alike: np.ndarray
    tails: float
    seen: int = 0
    beyond: int = 0

    @classmethod
    def first(cls, unknowns: int) -> "Scatter":
        """Initial scatter, before any run is explained."""
        return cls(np.ones(unknowns), np.full(unknowns, ARMS_DIFFER), FIRST_TAILS)

    @property
    def holds(self) -> bool:
        """Whether deviations agree with these tails; otherwise the rate of false alarms is unknown."""
        return _agrees(self.beyond, self.seen)


def scatter_of(squares: Sequence[np.ndarray], seen: Sequence[np.ndarray], groups: Sequence[str]) -> Scatter:
    """Scatter from the runs of each arm.

    Args:
        squares: For each arm, squared deviations of its runs over the variance of the type, shape (r, m).
        seen: For each arm, share of the deviations that is determined by the run, shape (r, m).
        groups: Effect of each unknown; empty for an unknown that does not scatter.
    """
    shown = np.median(np.concatenate(seen), axis=0) > SHOWN
    columns = np.flatnonzero(shown & (np.array(groups) != ""))
    scatter = Scatter.first(len(groups))
    arms = (
        [of_arm[np.median(of_arm[:, columns], axis=1) < ODD][:, columns] for of_arm in squares]
        if len(columns)
        else []
    )
    arms = [of_arm for of_arm in arms if len(of_arm) > FEW_ARMS]
    if not arms:
        return scatter
    likely = [sum(_scaled(of_arm, tails)[1] for of_arm in arms) for tails in TAILS]
    likeliest = next(k for k, value in enumerate(likely) if value > max(likely) - TOLD_APART)
    tails, beyond = _agreeing(arms, TAILS[: likeliest + 1])
    scales = np.log([_scaled(of_arm, tails)[0] for of_arm in arms])  # (a, c)
    effects = np.array(groups)[columns]
    for effect in np.unique(effects):
        here = effects == effect
        of_joint, of_effect = np.median(scales[:, here], axis=0), np.median(scales[:, here])
        middle = (len(arms) * of_joint + FEW_ARMS * of_effect) / (len(arms) + FEW_ARMS)
        scatter.variance[columns[here]] = np.exp(middle)
        if len(arms) >= FEW_ARMS:
            runs = float(np.median([len(of_arm) for of_arm in arms]))
            scatter.alike[columns[here]] = _weight(scales[:, here] - of_joint, runs, tails)
    return scatter._replace(tails=tails, seen=sum(of_arm.size for of_arm in arms), beyond=beyond)


def _agreeing(arms: Sequence[np.ndarray], candidates: Sequence[float]) -> tuple[float, int]:
    """The lightest tails that agree with the deviations, or else the heaviest, and the number beyond them."""
    seen = sum(of_arm.size for of_arm in arms)
    for tails in reversed(candidates):
        limit = stats.t.isf(0.5 * RARE, tails) ** 2
        beyond = sum(int(np.sum(of_arm / _scaled(of_arm, tails)[0] > limit)) for of_arm in arms)
        if _agrees(beyond, seen):
            break
    return tails, beyond


def _agrees(beyond: int, seen: int) -> bool:
    return seen >= LEAST_SEEN and bool(stats.binom.sf(beyond - 1, seen, RARE) > BY_CHANCE)


def _scaled(squares: np.ndarray, tails: float) -> tuple[np.ndarray, float]:
    """Squared scale of each column (c,) by Student's distribution, and the log-likelihood."""
    scale = np.mean(squares, axis=0)
    for _ in range(ROUNDS):
        weight = (tails + 1.0) / (tails + squares / scale)
        scale = np.mean(weight * squares, axis=0)
    constant = (
        special.gammaln(0.5 * (tails + 1.0)) - special.gammaln(0.5 * tails) - 0.5 * np.log(np.pi * tails)
    )
    terms = constant - 0.5 * np.log(scale) - 0.5 * (tails + 1.0) * np.log1p(squares / (tails * scale))
    return scale, float(np.sum(terms))


def _weight(differences: np.ndarray, runs: float, tails: float) -> float:
    """Weight of the type in runs, by log-variances of arms relative to their median, corrected for chance."""
    variance = (1.4826 * float(np.median(np.abs(differences)))) ** 2
    chance = 2.0 * (tails + 3.0) / (tails * runs)  # by Fisher's information of Student's scale
    return float(np.clip(2.0 / max(variance - chance, 2.0 / ALIKE), ARMS_DIFFER, ALIKE))
