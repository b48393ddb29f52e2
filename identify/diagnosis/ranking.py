"""Ranking: hypotheses by evidence, each in its best shape and beside noise of its own colour."""

from collections.abc import Sequence
from dataclasses import replace

from .candidate import Candidate, Thinned
from .driven import Driven
from .hypothesis import WORTH, Hypothesis, refined, reshaped, weigh
from .recolouring import recoloured
from .solution import Solution

REFINE = 6
"""Hypotheses whose shape is refined before the best is chosen."""
RECOLOUR, COLOURED, SHARE = 12, 4, 0.2
"""Hypotheses that are weighed beside noise of their own colour, at most and at least; and the share of the
foremost one's evidence below which no other has come first that way."""
ANEW = 3
"""Hypotheses whose shape is refined again, beside noise of that colour."""


def ranked(
    solution: Solution, every: Sequence[tuple[Candidate, Thinned]], runs: Sequence[Driven]
) -> list[Hypothesis]:
    """Hypotheses by evidence: the shapes of the foremost refined, each beside noise of its own colour."""
    weighed = weigh(solution, every)
    chosen = [
        place
        for place, one in enumerate(weighed[:RECOLOUR])
        if place < COLOURED or one.own > SHARE * weighed[0].own
    ]
    first = [
        refined(solution, weighed[place], runs)
        if place < REFINE and _near(weighed[place], weighed[0])
        else weighed[place]
        for place in chosen
    ]
    found = [recoloured(solution, one) for one in first]
    found.sort(key=lambda pair: -pair[0].evidence)
    for place, (one, whitening) in enumerate(found[:ANEW]):
        if one.candidate.bounds and _near(one, found[0][0]):
            colour = replace(solution, whitening=whitening)
            found[place] = recoloured(solution, reshaped(colour, one, runs))
    best = [one for one, _ in found] + [one for k, one in enumerate(weighed) if k not in chosen]
    return sorted(best, key=lambda one: -one.evidence)


def _near(one: Hypothesis, best: Hypothesis) -> bool:
    """Whether another shape between those that were tried may make it credible, and the best."""
    return one.own > max(WORTH, 0.5 * best.own)
