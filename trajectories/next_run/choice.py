"""Choice: the run that settles most per second, or why none is made."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exidyn.identification.diagnosis.belief.belief import Belief
from exidyn.identification.diagnosis.belief.open_items import (
    Item,
    compared,
    expected_entropies,
    information,
    items,
)
from exidyn.identification.diagnosis.belief.run_columns import RunColumns

from ..discrimination.distinction import HOUR
from .offers import Offer

WORTH = 0.05
"""Share of an item's entropy that a run has to take off to be worthwhile, or an hour of it so that the item
counts as decidable."""
RUN, DECIDED, UNDECIDABLE, OUT_OF_TIME = "run", "decided", "undecidable", "out of time"
"""What comes next."""


@dataclass(frozen=True, eq=False)
class Forecast:
    """What is expected of a run.

    Attributes:
        offer: The run.
        left: Entropy of each item that it leaves open, expected, shape (i,) [nat].
        left_hour: The same of an hour of it, shape (i,) [nat].
        gained: By how much less what is open is behind it [nat].
    """

    offer: Offer
    left: np.ndarray
    left_hour: np.ndarray
    gained: float

    @property
    def rate(self) -> float:
        """Information that is gained in a second [nat/s]."""
        return self.gained / self.offer.seconds


def forecasts(belief: Belief, offers: Sequence[Offer], runs: Sequence[RunColumns]) -> list[Forecast]:
    """What is expected of every offer, the one that gains most per second first."""
    questions, before = compared(belief), items(belief)
    found = []
    for offer, run in zip(offers, runs, strict=True):
        seen = information(belief, run)
        left = expected_entropies(belief, questions, seen)
        gained = sum(one.entropy - after for one, after in zip(before, left, strict=True) if one.open)
        # No less than its first run, however alike torques come to be beside all that an hour shows.
        hour = np.minimum(left, expected_entropies(belief, questions, HOUR / offer.motion * seen))
        found.append(Forecast(offer, left, hour, float(gained)))
    return sorted(found, key=lambda one: -one.rate)


@dataclass(frozen=True, eq=False)
class Choice:
    """What comes next, and why.

    Attributes:
        verdict: One of `RUN`, `DECIDED`, `UNDECIDABLE` and `OUT_OF_TIME`.
        items: Everything that was or is open.
        forecasts: Forecasts of all offers, the best first.
        decidable: Whether some run on offer, made for an hour, would take something off each item, (i,).
    """

    verdict: str
    items: tuple[Item, ...]
    forecasts: tuple[Forecast, ...]
    decidable: tuple[bool, ...]

    @property
    def chosen(self) -> Forecast | None:
        """The run that comes next."""
        return self.forecasts[0] if self.verdict == RUN else None

    @property
    def entropy(self) -> float:
        """Of everything that is open [nat]."""
        return sum(one.entropy for one in self.items if one.open)

    @property
    def remains(self) -> tuple[Item, ...]:
        """What is open and no run on offer would settle."""
        pairs = zip(self.items, self.decidable, strict=True)
        return tuple(one for one, decidable in pairs if one.open and not decidable)


def choose(
    belief: Belief,
    offers: Sequence[Offer],
    runs: Sequence[RunColumns],
    seconds: float,
    unexplained: bool = False,
) -> Choice:
    """The offer that gains most per second.

    Args:
        belief: What is open.
        offers: What could be made or taken.
        runs: Columns of each.
        seconds: Seconds of motion that are left [s].
        unexplained: Whether something is left that no effect explains, whatever the run.
    """
    found, every = forecasts(belief, offers, runs), items(belief)
    decidable = tuple(
        any(one.left_hour[place] < (1.0 - WORTH) * item.entropy for one in found)
        for place, item in enumerate(every)
    )
    open_ones = [place for place, one in enumerate(every) if one.open]
    asked = [place for place in open_ones if decidable[place]]
    ordered = _ordered(every, found, asked, seconds)
    if asked:
        verdict = RUN if ordered[0].offer.motion <= seconds else OUT_OF_TIME
    else:
        verdict = UNDECIDABLE if open_ones or unexplained else DECIDED
    return Choice(verdict, tuple(every), ordered, decidable)


def _ordered(
    every: Sequence[Item], found: Sequence[Forecast], asked: Sequence[int], seconds: float
) -> tuple[Forecast, ...]:
    """Forecasts, those first that there is time for, and of these those that are worth while.

    By what they take off that which some run decides; where there is nothing, off everything.
    """
    asked = asked or range(len(every))

    def last(one: Forecast) -> tuple[bool, bool, float]:
        worth = any(one.left[place] < (1.0 - WORTH) * every[place].entropy for place in asked)
        gained = sum(every[place].entropy - one.left[place] for place in asked)
        return one.offer.motion > seconds, not worth, -gained / one.offer.seconds

    return tuple(sorted(found, key=last))
