"""The best programme of two or three runs: the shortest that suffices for most of some arms."""

from collections.abc import Callable, Iterable, Sequence

from .answer import Answer
from .case import Case
from .programme import Programme, Run, programmes

PAIRS, KEPT = 6, 10
"""Pairs that get a third run, and programmes that all arms are asked about: the best so far."""
FEW = 2
"""Arms by which programmes are compared at first."""

Asked = Callable[[Sequence[tuple[Case, Programme]]], list[Answer]]
"""What programmes say of arms, all at once."""


def best_programme(cases: Sequence[Case], asked: Asked, quick: bool = False) -> tuple[Programme, float]:
    """The best one and for how many of the arms it suffices, from 0 to 1.

    Pairs first; the best of them get a third run; the best of all are compared by all arms.
    """
    few, pairs = cases[-FEW:], list(_pairs(quick))
    ranked = _ranked(pairs, few, asked)
    more = [] if quick else list(_with_a_third(ranked[:PAIRS]))
    ranked = _ranked([*pairs, *more], few, asked)[: 2 if quick else KEPT]
    ranked = _ranked(ranked, few if quick else cases, asked)
    best = ranked[0]
    suffices = [
        answer.suffices(case) for case, answer in zip(cases, asked([(c, best) for c in cases]), strict=True)
    ]
    return best, sum(suffices) / len(suffices)


def _pairs(quick: bool) -> list[Programme]:
    pairs = [one for one in programmes() if len(one) == 2]
    return pairs[:2] if quick else pairs


def _with_a_third(pairs: Iterable[Programme]) -> Iterable[Programme]:
    every: set[Run] = {run for one in programmes() if len(one) == 3 for run in one}
    found = {
        frozenset((*pair, run)) for pair in pairs for run in every if run not in pair and _short(pair, every)
    }
    return [tuple(sorted(one)) for one in sorted(found, key=sorted)]


def _short(pair: Programme, every: set[Run]) -> bool:
    return all(run in every for run in pair)


def _ranked(every: Sequence[Programme], cases: Sequence[Case], asked: Asked) -> list[Programme]:
    """Those that suffice for most arms first, of these the shortest."""
    answers = asked([(case, one) for one in every for case in cases])
    found = []
    for place, one in enumerate(every):
        own = answers[place * len(cases) : (place + 1) * len(cases)]
        enough = sum(answer.suffices(case) for case, answer in zip(cases, own, strict=True))
        found.append((-enough, sum(answer.motion for answer in own), one))
    return [one for _, _, one in sorted(found)]
