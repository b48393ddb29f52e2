"""Search: one effect at a time is added, everything solved anew, until nothing more is credible."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..model import Model
from .candidate import Candidate, Thinned
from .candidates import candidates
from .driven import Driven
from .hypothesis import Hypothesis, refined, weigh, weighed
from .nuisances import with_nuisances
from .rows import Rows, model_rows
from .solution import Solution
from .whitening import Whitening

AGAIN = 2
"""Times the colour of the residual is taken anew: it changes little after the first."""
MOST = 4
"""Effects that are looked for; an arm with more than that needs another belief, not a diagnosis."""
REFINE = 6
"""Hypotheses whose shape is refined before the best is chosen."""
PRIOR = 0.5
"""Probability before the data that something is missing."""
CREDIBLE = 0.95
"""Probability from which on something is taken to be there, and below which it is taken out again."""
BETTER = np.log(20.0)
"""Logarithm of the odds at which a finding gives way to another that explains the same."""

Asked = Sequence[tuple[Candidate, Thinned]]


class Found(NamedTuple):
    """An effect that was found, and what else it might be.

    Attributes:
        hypothesis: The effect.
        probability: That it, and nothing else on the list and not nothing, is the one.
        others: Hypotheses that the data do not exclude, the most credible first, with their probability.
    """

    hypothesis: Hypothesis
    probability: float
    others: tuple[tuple[Hypothesis, float], ...]


@dataclass(frozen=True, eq=False)
class Searched:
    """What a search has come to.

    Attributes:
        runs: Those that were fitted.
        rows: With columns for everything that was found, at their end.
        solution: Of these rows.
        found: In the order of their columns.
        believed: Solution without any of them.
        next: The best of what was not credible any more.
    """

    runs: tuple[Driven, ...]
    rows: Rows
    solution: Solution
    found: tuple[Found, ...]
    believed: Solution
    next: tuple[Hypothesis, ...]

    def keeping(self, places: Sequence[int]) -> "Searched":
        """With some of the findings only."""
        found = tuple(self.found[place] for place in places)
        rows = with_found(self.believed.rows, [one.hypothesis for one in found])
        return replace(self, rows=rows, solution=solved(rows), found=found)


def search(model: Model, runs: Sequence[Driven]) -> Searched:
    """Find what the model leaves out.

    Args:
        model: As believed, with its tolerances and with the payloads of the runs.
        runs: Those that may be fitted.
    """
    base = model_rows(model, runs)
    rough = solved(base)
    runs = [run.after(model, model.believed_values + rough.values[: len(model.names)]) for run in runs]
    rows = with_nuisances(base, model, runs)
    every = [(candidate, Thinned.of(candidate, runs)) for candidate in candidates(model)]
    count = len({candidate.key for candidate, _ in every})
    found: list[Found] = []
    while True:
        best = ranked(solved(_with(rows, found)), _unlike(every, found), runs)
        one = judged(best, count)
        if one is None or len(found) == MOST:
            break
        found = _settled(rows, every, runs, [*found, one], count)
    final = _with(rows, found)
    return Searched(tuple(runs), final, solved(final), tuple(found), solved(rows), tuple(best[:3]))


def _settled(rows: Rows, every: Asked, runs: Sequence[Driven], found: list[Found], count: int) -> list[Found]:
    """Findings that are each still the best, and still needed, beside the others."""
    for one in found[:-1]:
        others = [other for other in found if other is not one]
        best = ranked(solved(_with(rows, others)), _unlike(every, others), runs)
        again = judged(best, count)
        if again is None:
            found = others
            continue
        own = [h for h in best if h.candidate.key == one.hypothesis.candidate.key]
        if own and best[0].evidence - own[0].evidence < BETTER:
            again = judged([own[0], *(h for h in best if h is not own[0])], count) or again
        found = [again if other is one else other for other in found]
    return found


def solved(rows: Rows) -> Solution:
    """Solution of rows whose residual is white; its colour is found on the way."""
    flat = np.ones((rows.difference.shape[1], 1))
    start = Whitening.of(rows.difference, rows.weight, rows.runs)
    solution = Solution(rows, replace(start, filters=flat, valid=rows.weight > 0))
    for _ in range(AGAIN):
        solution = Solution(rows, Whitening.of(solution.residual, rows.weight, rows.runs))
    return solution


def ranked(solution: Solution, every: Asked, runs: Sequence[Driven]) -> list[Hypothesis]:
    """Hypotheses by evidence, the shapes of the foremost refined."""
    found = weigh(solution, every)
    first = [refined(solution, one, runs) for one in found[:REFINE]]
    return sorted([*first, *found[REFINE:]], key=lambda one: -one.evidence)


def judged(best: Sequence[Hypothesis], count: int) -> Found | None:
    """The foremost hypothesis, if it is credible that anything is there at all.

    Every one of `count` hypotheses is as likely as the others before the data, and together they are as
    likely as nothing.
    """
    if not best:
        return None
    logs = np.array([one.evidence for one in best]) + np.log(PRIOR / (1 - PRIOR) / count)
    total = np.logaddexp.reduce(np.append(logs, 0.0))
    if 1.0 - np.exp(-total) < CREDIBLE:
        return None
    probability = np.exp(logs - total)
    others = [(one, float(p)) for one, p in zip(best[1:], probability[1:], strict=True) if p > 1 - CREDIBLE]
    return Found(best[0], float(probability[0]), tuple(others))


def with_found(rows: Rows, found: Sequence[Hypothesis]) -> Rows:
    """Rows with the columns of hypotheses, their coefficients believed as when they were weighed."""
    for one in found:
        columns = one.columns.everywhere(rows.difference.shape[1])
        names = [f"{one.candidate.effect} {name}" for name in one.candidate.names]
        rows = rows.plus(names, columns, one.columns.found_std)
    return rows


def _with(rows: Rows, found: Sequence[Found]) -> Rows:
    return with_found(rows, [one.hypothesis for one in found])


def _unlike(every: Asked, found: Sequence[Found]) -> list[tuple[Candidate, Thinned]]:
    """What has not been found yet."""
    taken = {one.hypothesis.candidate.key for one in found}
    return [pair for pair in every if pair[0].key not in taken]


__all__ = ["Found", "Searched", "search", "solved", "weighed"]
