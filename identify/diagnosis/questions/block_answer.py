"""Block answer: how a candidate changes the prediction of each block by the others."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..blocks.block_likelihood import above_zero, all_or_nothing
from ..blocks.prediction import CERTAIN
from .candidate import SIZE, Candidate, Thinned

USUAL = 10.0
"""Prior deviation of a coefficient over its expected size: by itself it may give the joint's usual torque."""
WIDE = 1000.0
"""The same ratio where coefficients cancel, as those of a spring and its pretension do."""

CREDIBLE = 0.95
"""Probability from which on an effect counts as found, and below which it is removed again."""
CERTAIN_ODDS = float(np.log(CREDIBLE / (1 - CREDIBLE)))
"""Log odds at that probability."""
STRANGE = 4.0
"""Standard deviations from the expected size at which it is not that effect: one in 16,000."""


def against_all(*odds: float) -> float:
    """Log odds against several alternatives together, from the log odds against each."""
    return -float(np.logaddexp.reduce([-alternative for alternative in odds]))


def prior_std(candidate: Candidate, columns: Thinned) -> np.ndarray:
    """Prior standard deviation of each coefficient, shape (p,); wide where physics does not give one."""
    if candidate.expected is not None:
        return columns.std
    if candidate.cancels:
        return WIDE * columns.std
    return min(USUAL, candidate.size / SIZE) * columns.std


@dataclass(frozen=True, eq=False)
class Answer:
    """How a candidate changes the prediction of left-out blocks."""

    candidate: Candidate  # candidate in one shape
    columns: Thinned  # columns of the candidate
    values: np.ndarray  # coefficients fitted to all fitted blocks, shape (p,)
    free: np.ndarray  # whether each coefficient is within its physical limit, not at it, shape (p,)
    predicted: np.ndarray  # squared prediction errors of the blocks without it, shape (k, n) [(N m)^2]
    errors: np.ndarray  # squared prediction errors of the blocks with it, shape (k, n) [(N m)^2]
    along: np.ndarray  # residual of each block along the predicted effect, over noise, shape (k,)
    size: np.ndarray  # square of the predicted effect in each block, over noise, shape (k,)
    gains: np.ndarray  # gain in log probability of each block and joint, shape (k, n)
    independent: np.ndarray  # independent rows over all rows for the gains, shape (n,)
    fitted: np.ndarray  # whether a block is fitted, shape (k,); the others are held out
    cost: float = 0.0  # log of the number of shapes it was chosen from, less that of excluded signs
    relief: float = 0.0  # gain in log probability of all priors
    choice: float = 0.0  # cost of choosing the shape in the log odds by scatter
    # log odds by the blocks' scatter, keyed by `sized`: copies of an answer share them
    scatter: dict[bool, float] = field(default_factory=dict)

    @property
    def numbers(self) -> int:
        """How many numbers describe it: coefficients, and constants of its shape."""
        return len(self.values) + len(self.candidate.bounds)

    @property
    def strange(self) -> bool:
        """Whether a coefficient is too far from its expected size to be this effect."""
        sized = self.columns.mean != 0.0
        deviation = np.abs(self.values - self.columns.mean)[sized]
        return bool(np.any(deviation > STRANGE * self.columns.std[sized]))

    @cached_property
    def gain(self) -> float:
        """Gain in log probability of the fitted blocks, each predicted by the others, and of the priors.

        Held-out runs are not included: they check what was chosen.
        """
        return float(self.by_joint.sum()) + self.relief - self.cost

    @cached_property
    def by_joint(self) -> np.ndarray:
        """Contribution of each joint's fitted blocks to the gain, shape (n,)."""
        return np.asarray(self.gains[self.fitted].sum(axis=0))

    @property
    def joint(self) -> int:
        """Index of the joint that shows it best, from 0."""
        return int(np.argmax(self.by_joint))

    @cached_property
    def held_out(self) -> float:
        """Gain in log probability of the held-out blocks; zero without any."""
        return float(self.gains[~self.fitted].sum())

    @property
    def scatter_held_out(self) -> float:
        """Expected loss in log probability of held-out blocks from scatter of the coefficients alone.

        It is one half for each free coefficient (Akaike), times the ratio of held-out to fitted blocks.
        """
        return 0.5 * float(self.free.sum()) * float((~self.fitted).sum() / max(self.fitted.sum(), 1))

    @cached_property
    def sized(self) -> bool:
        """Whether physics gives its size, so that it is there as predicted or not at all."""
        return bool(np.any(self.columns.mean != 0.0))

    @property
    def log_odds(self) -> float:
        """Log odds that left-out blocks contain the effect, from their scatter.

        An effect of known size is there as predicted or not at all; any other may have any amplitude.
        """
        if self.sized not in self.scatter:
            compute_scatter_odds([self])
        return self.scatter[self.sized]

    @property
    def scatter_odds(self) -> float:
        """Log odds by scatter with the gain of the priors, less the cost of choosing a shape."""
        return self.log_odds + self.relief - self.choice

    @cached_property
    def odds(self) -> float:
        """Log odds that it is there, before the prior of its hypothesis.

        Two alternatives share the prior of "no effect": there is none, or there is a misfit that differs from
        block to block and resembles the effect by chance.
        """
        return against_all(self.gain, self.scatter_odds) + float(np.log(2.0))

    def chosen_as(self, other: "Answer") -> "Answer":
        """This answer at the cost of another choice of shape."""
        return replace(self, cost=other.cost, choice=other.choice)

    @property
    def torque(self) -> np.ndarray:
        """Torque on the m joints of its columns, shape (r, m) [N m]."""
        return self.columns.values @ self.values

    @property
    def std(self) -> np.ndarray:
        """Prior standard deviation of each coefficient once the effect is in the model, shape (p,)."""
        return np.where(self.free, prior_std(self.candidate, self.columns), CERTAIN)

    @property
    def mean(self) -> np.ndarray:
        """Prior mean of each coefficient once the effect is in the model, shape (p,)."""
        return np.where(self.free, self.columns.mean, self.values)


def compute_scatter_odds(answers: Sequence[Answer]) -> None:
    """Compute the odds by scatter of several answers together, several times faster than one by one."""
    for sized in (False, True):
        group = [answer for answer in answers if answer.sized == sized and sized not in answer.scatter]
        if not group:
            continue
        along = np.stack([answer.along[answer.fitted] for answer in group])
        size = np.stack([answer.size[answer.fitted] for answer in group])
        odds = all_or_nothing(along, size) if sized else above_zero(along, size)
        for answer, log_odds in zip(group, odds.tolist(), strict=True):
            answer.scatter[sized] = log_odds
