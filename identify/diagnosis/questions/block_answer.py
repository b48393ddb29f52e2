"""Block answer: what a candidate does for each of the blocks, predicted by the others."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..blocks.block_likelihood import Amplitude, all_or_nothing_of_each, amplitude, amplitudes
from ..blocks.prediction import CERTAIN
from .candidate import SIZE, Candidate, Thinned

USUAL = 10.0
"""How far a coefficient may be, over what is expected of it: alone it gives the joint's usual torque."""
WIDE = 1000.0
"""That limit where coefficients cancel, as those of a spring and its pretension do."""

CREDIBLE = 0.95
"""Probability from which on something is taken to be there, and below which it is taken out again."""
CERTAIN_ODDS = float(np.log(CREDIBLE / (1 - CREDIBLE)))
"""Logarithm of the odds at that probability."""
STRANGE = 4.0
"""Standard deviations from what physics expects at which something is not that effect: one in 16 000."""


def against_all(*odds: float) -> float:
    """Logarithm of the odds against several alternatives together, by those against each."""
    return -float(np.logaddexp.reduce([-one for one in odds]))


def prior_std(candidate: Candidate, columns: Thinned) -> np.ndarray:
    """How far each coefficient may be from its mean, shape (p,): flat where physics does not give one."""
    if candidate.expected is not None:
        return columns.std
    if candidate.cancels:
        return WIDE * columns.std
    return min(USUAL, candidate.size / SIZE) * columns.std


@dataclass(frozen=True, eq=False)
class Answer:
    """What a candidate does for the blocks that are left out."""

    candidate: Candidate  # in one shape
    columns: Thinned  # its columns
    values: np.ndarray  # its coefficients by all fitted blocks, shape (p,)
    free: np.ndarray  # which of them are not at a limit of physics, shape (p,)
    predicted: np.ndarray  # squares of the blocks as predicted without it, shape (k, n) [(N m)^2]
    errors: np.ndarray  # the same with it
    along: np.ndarray  # of each block, its residual along the predicted effect, over noise, shape (k,)
    size: np.ndarray  # of each block, square of the predicted effect, over noise, shape (k,)
    gains: np.ndarray  # logarithm of how much more probable each block is on each joint, shape (k, n)
    independent: np.ndarray  # independent rows over all rows for the gains, shape (n,)
    fitted: np.ndarray  # whether a block is fitted, shape (k,); the others are only predicted
    cost: float = 0.0  # logarithm of the number of shapes it was chosen of, less that of excluded signs
    relief: float = 0.0  # logarithm of how much more probable all priors are, beside it
    choice: float = 0.0  # what choosing the shape costs the odds by scatter, on a logarithm
    # odds by the blocks' scatter, by whether the effect is there whole: copies of an answer share them
    scatter: dict[bool, float] = field(default_factory=dict)

    @property
    def strange(self) -> bool:
        """Whether a coefficient is so far from what physics expects that it is not this effect."""
        known = self.columns.mean != 0.0
        apart = np.abs(self.values - self.columns.mean)[known]
        return bool(np.any(apart > STRANGE * self.columns.std[known]))

    @cached_property
    def gain(self) -> float:
        """Logarithm of how much more probable fitted blocks are, each predicted by the others, and priors.

        Runs held out have no part in it: they judge what was chosen.
        """
        return float(self.by_joint.sum()) + self.relief - self.cost

    @cached_property
    def by_joint(self) -> np.ndarray:
        """What each joint contributes to that by its blocks, shape (n,)."""
        return np.asarray(self.gains[self.fitted].sum(axis=0))

    @cached_property
    def held_out(self) -> float:
        """Log of how much more probable blocks are that are only predicted; zero without any."""
        return float(self.gains[~self.fitted].sum())

    @property
    def scatter_held_out(self) -> float:
        """By how much less probable scatter of the coefficients alone makes blocks that are only predicted.

        Half for each that is free (Akaike), by the number of those blocks over that of the fitted.
        """
        return 0.5 * float(self.free.sum()) * float((~self.fitted).sum() / max(self.fitted.sum(), 1))

    @cached_property
    def amplitude(self) -> Amplitude:
        """How much of the predicted effect the blocks have."""
        return amplitude(self.along[self.fitted], self.size[self.fitted])

    @cached_property
    def whole(self) -> bool:
        """Whether it is there as predicted or not at all, since physics gives its size."""
        return bool(np.any(self.columns.mean != 0.0))

    @property
    def log_odds(self) -> float:
        """Logarithm of the odds that blocks left out have the effect, by how they scatter.

        One whose size physics gives is there as predicted or not at all; of any other, some is.
        """
        if self.whole not in self.scatter:
            scattered([self])
        return self.scatter[self.whole]

    @property
    def scatter_odds(self) -> float:
        """Those odds with what priors say, less the cost of choosing a shape."""
        return self.log_odds + self.relief - self.choice

    @cached_property
    def odds(self) -> float:
        """Logarithm of the odds that it is there, before the prior of its hypothesis.

        Against two alternatives that share the prior of nothing: nothing is there, or a misfit that differs
        from block to block and has something of its direction by chance.
        """
        return against_all(self.gain, self.scatter_odds) + float(np.log(2.0))

    def chosen_as(self, other: "Answer") -> "Answer":
        """This answer at the cost of another choice of shape."""
        return replace(self, cost=other.cost, choice=other.choice)

    @property
    def torque(self) -> np.ndarray:
        """Its torque, shape (r, m) of the joints of its columns [N m]."""
        return self.columns.values @ self.values

    @property
    def std(self) -> np.ndarray:
        """How far each coefficient may be from its mean once the effect is in the model, shape (p,)."""
        return np.where(self.free, prior_std(self.candidate, self.columns), CERTAIN)

    @property
    def mean(self) -> np.ndarray:
        """What each coefficient is then held to be, shape (p,)."""
        return np.where(self.free, self.columns.mean, self.values)


def scattered(answers: Sequence[Answer]) -> None:
    """Work out the odds by scatter of some answers together: one by one, that takes several times as long."""
    for whole in (False, True):
        alike = [one for one in answers if one.whole == whole and whole not in one.scatter]
        if not alike:
            continue
        along = np.stack([one.along[one.fitted] for one in alike])
        size = np.stack([one.size[one.fitted] for one in alike])
        odds = (
            all_or_nothing_of_each(along, size).tolist()
            if whole
            else [amplitude.log_odds for amplitude in amplitudes(along, size)]
        )
        for one, own in zip(alike, odds, strict=True):
            one.scatter[whole] = own
