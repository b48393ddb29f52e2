"""Found: a hypothesis that is credible, and what else may explain the same."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .hypothesis import Hypothesis

PRIOR = 0.5
"""Probability before the data that something is missing."""
CREDIBLE = 0.95
"""Probability from which on something is taken to be there, and below which it is taken out again."""
EXCLUDED = 0.01
"""Probability below which something is no alternative any more: nobody is told to look for it."""
CERTAIN_ODDS = float(np.log(CREDIBLE / (1 - CREDIBLE)))
"""Logarithm of the odds at that probability."""


class Found(NamedTuple):
    """An effect that was found, and what else it might be.

    Attributes:
        hypothesis: The effect.
        others: What may explain the same, the most credible first, with the logarithm of its odds.
        odds: Its own.
    """

    hypothesis: Hypothesis
    others: tuple[tuple[Hypothesis, float], ...]
    odds: float

    @property
    def probability(self) -> float:
        """That it is there, and that it is this and nothing else that explains the same."""
        logs = [0.0, self.odds, *(odds for _, odds in self.others)]
        return float(np.exp(self.odds - np.logaddexp.reduce(logs)))

    @property
    def not_excluded(self) -> list[tuple[Hypothesis, float]]:
        """Others that are credible enough to be told, with their probability."""
        total = np.logaddexp.reduce([0.0, self.odds, *(odds for _, odds in self.others)])
        every = [(one, float(np.exp(odds - total))) for one, odds in self.others]
        return [(one, p) for one, p in every if p > EXCLUDED]

    def beside(self, best: Sequence[Hypothesis], count: int) -> "Found":
        """Without those others that are as credible beside it as they were instead of it.

        Args:
            best: What there may be beside everything found.
            count: Number of hypotheses.
        """
        too = {one.candidate.key for one in best if odds_of(one, count) > CERTAIN_ODDS}
        return self._replace(others=tuple(pair for pair in self.others if pair[0].candidate.key not in too))


def odds_of(hypothesis: Hypothesis, count: int) -> float:
    """Logarithm of the odds of a hypothesis against nothing more.

    Every one of `count` hypotheses is as likely as the others before the data, and together they are as
    likely as nothing.
    """
    return float(hypothesis.evidence + np.log(PRIOR / (1 - PRIOR) / count))


def judged(best: Sequence[Hypothesis], count: int) -> Found | None:
    """The foremost hypothesis, if it is credible that anything is there at all."""
    if not best:
        return None
    odds = [odds_of(one, count) for one in best]
    if np.logaddexp.reduce(odds) < CERTAIN_ODDS:
        return None
    others = [
        pair for pair in zip(best[1:], odds[1:], strict=True) if competing(pair[0], best[0]) and pair[1] > -20
    ]
    return Found(best[0], tuple(others), odds[0])


def competing(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether both give torque to one joint, and so may explain the same."""
    return bool(np.intersect1d(one.columns.joints, other.columns.joints).size)
