"""Probabilities of hypotheses from what speaks for each, and what is said of them."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

Key = TypeVar("Key", bound=Hashable)

DECIDED = 0.95
"""Probability from which on a guess is written down: at most one in twenty of those at the limit is wrong."""


@dataclass(frozen=True)
class Guess:
    """One thing that was guessed.

    Attributes:
        what: Is asked.
        value: The likeliest answer.
        probability: Of that answer, among those that were weighed, given the log and the robot.
        why: What speaks for it.
        option: What a person does where it is wrong or not decided.
    """

    what: str
    value: str
    probability: float
    why: str
    option: str = ""

    @property
    def decided(self) -> bool:
        """Whether it is sure enough to be written down."""
        return self.probability >= DECIDED


def posterior(log_odds: Mapping[Key, float]) -> dict[Key, float]:
    """Probability of each hypothesis, from log of prior times likelihood; the likeliest first."""
    values = np.array(list(log_odds.values()))
    weights = np.exp(values - values.max())
    found = dict(zip(log_odds, weights / weights.sum(), strict=True))
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def log_normal(value: float, middle: float, spread: float) -> float:
    """Log of the density of log(value), normal about log(middle) with standard deviation `spread`."""
    return float(-0.5 * (np.log(value / middle) / spread) ** 2 - np.log(spread * np.sqrt(2 * np.pi)))
