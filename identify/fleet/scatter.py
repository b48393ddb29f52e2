"""Scatter: how much runs of a type of arm differ by themselves, how far arms differ in that, and its tails.

Learnt from what runs deviate by once everything found on their arms is explained.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import special, stats

TAILS = (2.0, 2.5, 3.0, 4.0, 6.0, 10.0, 20.0, 50.0)
"""Degrees of freedom of Student's distribution that are asked for: no variance to as good as normal."""
FIRST_TAILS = 4.0
"""The same before anything is known."""
TOLD_APART = 2.0
"""Difference of log-likelihoods up to which the heavier tails are taken: odds of seven."""
ARMS_DIFFER = 2.0
"""Runs for which the scatter of its type counts against that of an arm, before arms are compared: one in ten
arms then scatters three times as much as its type, or a third."""
ALIKE = 40.0
"""The same at most: deviations of arms are never known to be the same to more than a sixth."""
FEW_ARMS = 3
"""Arms for which the other joints' same effect counts; also those from which on arms are compared."""
SHOWN = 0.5
"""Share of a deviation that runs show, from which on it counts: the rest is what was believed before."""
ODD = 5.0
"""Median of squared deviations over their variance from which on all of a run is out of line."""
ROUNDS = 30
"""Of scales and weights, each from the other."""
RARE = 0.01
"""Probability at which tails are held against what is seen."""
LEAST_SEEN = 500
"""Deviations from which tails can be held against them: five are then expected to be rare."""
BY_CHANCE = 1e-3
"""Probability with which sound tails are found too light."""


class Scatter(NamedTuple):
    """Of the runs of a type.

    Attributes:
        variance: Of each unknown over what successive runs show, shape (m,).
        alike: Runs for which that counts against an arm's own, shape (m,).
        tails: Degrees of freedom of Student's distribution.
        seen: Deviations from which that is known.
        beyond: Those of them that are farther out than one in a hundred should be.
    """

    variance: np.ndarray
    alike: np.ndarray
    tails: float
    seen: int = 0
    beyond: int = 0

    @classmethod
    def first(cls, unknowns: int) -> "Scatter":
        """Before anything is known."""
        return cls(np.ones(unknowns), np.full(unknowns, ARMS_DIFFER), FIRST_TAILS)

    @property
    def holds(self) -> bool:
        """Whether no more deviations are far out than these tails allow: else no rate of alarms is known."""
        return _rightly(self.beyond, self.seen)


def scatter_of(squares: Sequence[np.ndarray], seen: Sequence[np.ndarray], groups: Sequence[str]) -> Scatter:
    """From the runs of each arm.

    Args:
        squares: Of each arm its runs' squared deviations over their usual variance, shape (r, m).
        seen: Share of them that each run shows, shape (r, m).
        groups: Effect of each unknown; empty of one that does not scatter by itself.
    """
    shown = np.median(np.concatenate(seen), axis=0) > SHOWN
    columns = np.flatnonzero(shown & (np.array(groups) != ""))
    found = Scatter.first(len(groups))
    arms = (
        [own[np.median(own[:, columns], axis=1) < ODD][:, columns] for own in squares] if len(columns) else []
    )
    arms = [own for own in arms if len(own) > FEW_ARMS]
    if not arms:
        return found
    likely = [sum(_scaled(own, tails)[1] for own in arms) for tails in TAILS]
    likeliest = next(k for k, value in enumerate(likely) if value > max(likely) - TOLD_APART)
    tails, beyond = _that_hold(arms, TAILS[: likeliest + 1])
    scales = np.log([_scaled(own, tails)[0] for own in arms])  # (a, c)
    effects = np.array(groups)[columns]
    for effect in np.unique(effects):
        here = effects == effect
        own, whole = np.median(scales[:, here], axis=0), np.median(scales[:, here])
        middle = (len(arms) * own + FEW_ARMS * whole) / (len(arms) + FEW_ARMS)
        found.variance[columns[here]] = np.exp(middle)
        if len(arms) >= FEW_ARMS:
            runs = float(np.median([len(one) for one in arms]))
            found.alike[columns[here]] = _alike(scales[:, here] - own, runs, tails)
    return found._replace(tails=tails, seen=sum(one.size for one in arms), beyond=beyond)


def _that_hold(arms: Sequence[np.ndarray], asked: Sequence[float]) -> tuple[float, int]:
    """The lightest tails that allow as much as is far out, or the heaviest; and how much is far out."""
    seen = sum(own.size for own in arms)
    for tails in reversed(asked):
        limit = stats.t.isf(0.5 * RARE, tails) ** 2
        beyond = sum(int(np.sum(own / _scaled(own, tails)[0] > limit)) for own in arms)
        if _rightly(beyond, seen):
            break
    return tails, beyond


def _rightly(beyond: int, seen: int) -> bool:
    return seen >= LEAST_SEEN and bool(stats.binom.sf(beyond - 1, seen, RARE) > BY_CHANCE)


def _scaled(squares: np.ndarray, tails: float) -> tuple[np.ndarray, float]:
    """Squared scale of each column (c,) by Student's distribution, and the logarithm of the likelihood."""
    scale = np.mean(squares, axis=0)
    for _ in range(ROUNDS):
        weight = (tails + 1.0) / (tails + squares / scale)
        scale = np.mean(weight * squares, axis=0)
    constant = (
        special.gammaln(0.5 * (tails + 1.0)) - special.gammaln(0.5 * tails) - 0.5 * np.log(np.pi * tails)
    )
    each = constant - 0.5 * np.log(scale) - 0.5 * (tails + 1.0) * np.log1p(squares / (tails * scale))
    return scale, float(np.sum(each))


def _alike(apart: np.ndarray, runs: float, tails: float) -> float:
    """By the logarithms of arms' variances over their middle: what chance alone does is taken off."""
    seen = (1.4826 * float(np.median(np.abs(apart)))) ** 2
    chance = 2.0 * (tails + 3.0) / (tails * runs)  # Fisher's information of a scale of Student's distribution
    return float(np.clip(2.0 / max(seen - chance, 2.0 / ALIKE), ARMS_DIFFER, ALIKE))
