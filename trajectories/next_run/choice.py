"""Choice of the run that reduces uncertainty most per second, or the reason for no run."""

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
"""Share of an item's entropy that a worthwhile run removes; if an hour of a run does, it is decidable."""
RUN, DECIDED, UNDECIDABLE, OUT_OF_TIME = "run", "decided", "undecidable", "out of time"
"""Verdicts of a choice."""


@dataclass(frozen=True, eq=False)
class Forecast:
    """Expected result of a run.

    Attributes:
        offer: The run.
        entropy_after: Expected entropy of each item after the run, shape (i,) [nat].
        entropy_after_hour: Expected entropy of each item after an hour of the run, shape (i,) [nat].
        gained: Expected decrease of the entropy of open items [nat].
    """

    offer: Offer
    entropy_after: np.ndarray
    entropy_after_hour: np.ndarray
    gained: float

    @property
    def rate(self) -> float:
        """Expected decrease of entropy per second [nat/s]."""
        return self.gained / self.offer.seconds


def forecasts(belief: Belief, offers: Sequence[Offer], runs: Sequence[RunColumns]) -> list[Forecast]:
    """Forecasts of all offers, by decreasing gain per second."""
    questions, before = compared(belief), items(belief)
    forecasts = []
    for offer, run in zip(offers, runs, strict=True):
        seen = information(belief, run)
        after = expected_entropies(belief, questions, seen)
        gained = sum(item.entropy - entropy for item, entropy in zip(before, after, strict=True) if item.open)
        # an hour is never worse than the first run, even if torques of rivals become alike in it
        after_hour = np.minimum(after, expected_entropies(belief, questions, HOUR / offer.motion * seen))
        forecasts.append(Forecast(offer, after, after_hour, float(gained)))
    return sorted(forecasts, key=lambda forecast: -forecast.rate)


@dataclass(frozen=True, eq=False)
class Choice:
    """The next run, or why there is none.

    Attributes:
        verdict: One of `RUN`, `DECIDED`, `UNDECIDABLE` and `OUT_OF_TIME`.
        items: All items, open or settled.
        forecasts: Forecasts of all offers, the best first.
        decidable: Whether an hour of some run on offer would reduce the entropy of each item, shape (i,).
    """

    verdict: str
    items: tuple[Item, ...]
    forecasts: tuple[Forecast, ...]
    decidable: tuple[bool, ...]

    @property
    def chosen(self) -> Forecast | None:
        """Forecast of the next run; None if there is none."""
        return self.forecasts[0] if self.verdict == RUN else None

    @property
    def entropy(self) -> float:
        """Entropy of all open items [nat]."""
        return sum(item.entropy for item in self.items if item.open)

    @property
    def remains(self) -> tuple[Item, ...]:
        """Open items that no run on offer would settle."""
        pairs = zip(self.items, self.decidable, strict=True)
        return tuple(item for item, decidable in pairs if item.open and not decidable)


def choose(
    belief: Belief,
    offers: Sequence[Offer],
    runs: Sequence[RunColumns],
    seconds: float,
    unexplained: bool = False,
) -> Choice:
    """Choose the offer that gains most per second.

    Args:
        belief: Belief of the diagnosis.
        offers: Runs that could be made or taken.
        runs: Columns of each run.
        seconds: Remaining time of motion [s].
        unexplained: Whether there is a residual that no effect explains, for any run.
    """
    all_forecasts, all_items = forecasts(belief, offers, runs), items(belief)
    decidable = tuple(
        any(forecast.entropy_after_hour[place] < (1.0 - WORTH) * item.entropy for forecast in all_forecasts)
        for place, item in enumerate(all_items)
    )
    open_places = [place for place, item in enumerate(all_items) if item.open]
    decidable_places = [place for place in open_places if decidable[place]]
    ordered = _ordered(all_items, all_forecasts, decidable_places, seconds)
    if decidable_places:
        verdict = RUN if ordered[0].offer.motion <= seconds else OUT_OF_TIME
    else:
        verdict = UNDECIDABLE if open_places or unexplained else DECIDED
    return Choice(verdict, tuple(all_items), ordered, decidable)


def _ordered(
    all_items: Sequence[Item], all_forecasts: Sequence[Forecast], places: Sequence[int], seconds: float
) -> tuple[Forecast, ...]:
    """Forecasts sorted by whether the run fits the time and is worthwhile, then by its gain per second.

    The gain counts over the items at `places`, or over all items if there are none.
    """
    places = places or range(len(all_items))

    def sort_key(forecast: Forecast) -> tuple[bool, bool, float]:
        entropies = [(all_items[place].entropy, forecast.entropy_after[place]) for place in places]
        worthwhile = any(after < (1.0 - WORTH) * before for before, after in entropies)
        gained = sum(before - after for before, after in entropies)
        return forecast.offer.motion > seconds, not worthwhile, -gained / forecast.offer.seconds

    return tuple(sorted(all_forecasts, key=sort_key))
