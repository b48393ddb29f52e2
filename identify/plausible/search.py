"""Search for the mistakes that explain a log: one after another, at most three.

Three witnesses must agree before a mistake is named: it is more probable than none and than all others in the
table with which the log fits as correct logs do, and the described bodies do not contradict it.
"""

from collections.abc import Collection, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from heapq import nlargest
from typing import NamedTuple, TypeVar

import numpy as np

from .change import Change
from .evidence import Evidence, Reading
from .mistake import Case, LogFacts, Mistake
from .mistakes import MOUNTING, TABLE, TWO_CLOCKS
from .searched import search_clocks, search_gravity
from .size_mistakes import of_clocks, of_gravity

Key = TypeVar("Key", bound=Hashable)

MOST = 400
"""Maximum number of samples: hundreds of hypotheses are fitted to them."""
DEPTH = 3
"""Maximum number of mistakes in one log."""
FINALISTS = 10
"""Number of changes of positions or order that the described bodies judge, the best by bodies of any mass."""
CHANCE = 10.0
"""Log odds by which bodies of any mass may fit another motion better if the log fits as it is: up to 9 in 20
correct logs, since no model is exact."""
FAR_BEHIND = 7.0
"""Log odds behind no mistake at which a hypothesis is not evaluated further: one in a thousand."""


def posterior(log_odds: Mapping[Key, float]) -> dict[Key, float]:
    """Probability of each hypothesis from log of prior times likelihood, the most probable first."""
    values = np.array(list(log_odds.values()))
    weights = np.exp(values - values.max())
    shares = dict(zip(log_odds, (weights / weights.sum()).tolist(), strict=True))
    return dict(sorted(shares.items(), key=lambda item: -item[1]))


class Explanation(NamedTuple):
    """One or several mistakes in a log."""

    mistakes: tuple[Mistake, ...]  # kind of each mistake; none for the log as it is
    cases: tuple[Case, ...]  # each mistake
    change: Change  # correction of all of them
    odds: float  # log of prior times likelihood
    reading: Reading  # the corrected log
    evidence: Evidence  # its evidence

    @property
    def joints(self) -> tuple[int, ...]:
        """Joints that show the mistakes."""
        return tuple(sorted({joint for case in self.cases for joint in case.joints}))

    @property
    def kind(self) -> tuple[tuple[str, ...], tuple[int, ...]]:
        """Kinds and joints: mistakes of equal kind differ in size."""
        return tuple(sorted(mistake.name for mistake in self.mistakes)), self.joints

    @property
    def right(self) -> bool:
        """Whether the corrected log fits as correct logs do, and described bodies do not contradict it."""
        factor = self.change.factor
        # A common factor of all efforts changes no share: only masses see it.
        unseen = factor is not None and np.ptp(np.abs(factor)) == 0.0
        return self.evidence.agrees and (unseen or self.reading.fits)


@dataclass(frozen=True)
class Weighed:
    """Result of testing a log for all mistakes in the table."""

    plain: Explanation  # the log as it is
    explanations: tuple[Explanation, ...]  # mistakes, right ones first and then the most probable first

    def share(self, explanation: Explanation) -> float:
        """Probability of some mistakes, if one of those is made with which the log is right, or none."""
        odds = [
            self.plain.odds,
            *(other.odds for other in self.explanations if other.right or other is explanation),
        ]
        return float(np.exp(explanation.odds - np.logaddexp.reduce(odds)))

    @property
    def named(self) -> Explanation | None:
        """The most probable mistakes if the three witnesses agree on them."""
        best = self.explanations[0] if self.explanations else self.plain
        return best if best.right and best.odds > self.plain.odds else None

    @property
    def probability(self) -> float:
        """Probability of the kind of mistake that is named, of any size."""
        best = self.named
        alike = [other for other in self.explanations if best and other.right and other.kind == best.kind]
        return min(sum(map(self.share, alike)), 1.0)


def weigh(reading: Reading, facts: LogFacts, kinds: Collection[str] | None = None) -> Weighed:
    """Test a log for all mistakes in the table, or for some kinds, and for no mistake."""
    table = [mistake for mistake in TABLE if kinds is None or mistake.name in kinds]
    table = [mistake for mistake in table if reading.stated or not mistake.of_sizes]
    prior = float(np.log1p(-sum(mistake.prior for mistake in table)))
    plain = Explanation((), (), Change(), prior + reading.evidence.log_likelihood, reading, reading.evidence)
    explanations, start = _of_sizes(plain, facts, table), plain
    for _ in range(DEPTH):
        # If joints fit together as they do alone, only sizes and signs of efforts can be wrong.
        best = max((start, *explanations), key=lambda explanation: explanation.odds)
        if start.reading.fits_as_well and best.evidence.as_drawn:
            break
        more = _of_motion(start, facts, table)
        more += _of_sizes(start, facts, table) if start.cases else _searched(plain, facts, kinds is None)
        explanations += more
        following = max(more, key=_first, default=start)
        if following.odds <= start.odds:
            break
        start = following
    return Weighed(plain, tuple(sorted(explanations, key=_first, reverse=True)))


def _first(explanation: Explanation) -> tuple[bool, float]:
    return explanation.right, explanation.odds


def _cases(
    start: Explanation, facts: LogFacts, table: Sequence[Mistake], sizes: bool
) -> Iterator[tuple[float, Mistake, Case]]:
    """Log prior odds of each further mistake in a log corrected so far: of sizes of efforts, or others."""
    facts = replace(facts, log=start.reading.log)
    for mistake in table:
        each = list(mistake.cases(facts))
        prior = float(np.log(mistake.prior / max(len(each), 1)))
        for case in each:
            if (case.change.factor is not None) == sizes:
                yield prior + facts.usual(case.change), mistake, case


def _with(
    start: Explanation, prior: float, mistake: Mistake, case: Case, reading: Reading, seen: Evidence
) -> Explanation:
    """One more mistake, with the log that its correction makes and what is seen there."""
    before = start.odds - start.evidence.log_likelihood
    odds = before + prior + seen.log_likelihood
    change = start.change.then(case.change)
    return Explanation((*start.mistakes, mistake), (*start.cases, case), change, odds, reading, seen)


def _of_sizes(start: Explanation, facts: LogFacts, table: Sequence[Mistake]) -> list[Explanation]:
    """Other sizes and signs of efforts: described masses judge them quickly, bodies those that remain."""
    explanations = []
    for prior, mistake, case in _cases(start, facts, table, sizes=True):
        factor = case.change.factor
        assert factor is not None
        reading = start.reading.changed(case.change)
        seen = start.reading.evidence_of(factor)
        explanation = _with(start, prior, mistake, case, reading, seen)
        if np.ptp(factor) > 0.0 and (explanation.odds > start.odds - FAR_BEHIND or not start.reading.fits):
            explanation = _with(
                start, prior, mistake, case, reading, start.reading.evidence_of(factor, reading.shares)
            )
        if explanation.odds > start.odds - FAR_BEHIND:
            explanations.append(explanation)
    return explanations


def _of_motion(start: Explanation, facts: LogFacts, table: Sequence[Mistake]) -> list[Explanation]:
    """Other positions, orders, mixtures and gravity: the best by bodies of any mass, with their masses."""
    finalists = nlargest(FINALISTS, _quick(start, facts, table), key=lambda item: item[0])
    return [
        _with(start, prior - _by_chance(start, reading), mistake, case, reading, reading.evidence)
        for _, prior, mistake, case, reading in finalists
    ]


def _quick(
    start: Explanation, facts: LogFacts, table: Sequence[Mistake]
) -> Iterator[tuple[float, float, Mistake, Case, Reading]]:
    """Log odds by a single pass and prior of each case of another motion, with the reading that it makes."""

    def motion(item: tuple[float, Mistake, Case]) -> bytes:
        change = item[2].change
        return b"" if change.position is None or change.zero is not None else change.position.tobytes()

    # Several changes of efforts share one motion, whose columns take megabytes: they are freed with the last.
    before, earlier = b"", start.reading
    for prior, mistake, case in sorted(_cases(start, facts, table, sizes=False), key=motion):
        reading, now = start.reading.changed(case.change), motion((prior, mistake, case))
        if now and now == before:
            reading.__dict__["columns"] = earlier.columns
        before, earlier = now, reading
        yield prior + reading.quick, prior, mistake, case, reading


def _by_chance(start: Explanation, reading: Reading) -> float:
    """Part of a better fit of another motion that chance explains."""
    better = float((reading.evidence.by_bodies - start.evidence.by_bodies).sum())
    return min(max(better, 0.0), CHANCE) * start.reading.fits


def _searched(plain: Explanation, facts: LogFacts, clocks: bool) -> list[Explanation]:
    """Mistakes whose size is found by a search: another mounting, and another clock."""
    explanations = []
    if (gravity := search_gravity(plain.reading)) is not None:
        explanations.append((MOUNTING, of_gravity(facts, gravity)))
    if clocks and (late := search_clocks(plain.reading)) is not None:
        explanations.append((TWO_CLOCKS, of_clocks(facts, late)))
    readings = [plain.reading.changed(case.change) for _, case in explanations]
    return [
        _with(plain, float(np.log(mistake.prior)), mistake, case, reading, reading.evidence)
        for (mistake, case), reading in zip(explanations, readings, strict=True)
    ]
