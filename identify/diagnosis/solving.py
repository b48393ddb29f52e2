"""Solving: rows with what was found, and their solution beside noise of its own colour."""

from collections.abc import Sequence

from .candidate import Thinned
from .hypothesis import Hypothesis
from .rows import Rows
from .solution import Solution
from .whitening import Whitening

AGAIN = 8
"""Times that unknowns and colour are found in turn, at most."""
SETTLED = 0.1
"""Change of the logarithm of a probability that is not worth another turn."""


def solved(rows: Rows) -> Solution:
    """Solution of rows whose residual is white; its colour is found on the way."""
    solution = Solution(rows, Whitening.of(rows.difference, rows.weight, rows.runs, order=0))
    coloured = Solution(rows, Whitening.of(solution.residual, rows.weight, rows.runs))
    for _ in range(AGAIN):
        again = Solution(rows, Whitening.of(coloured.residual, rows.weight, rows.runs))
        if again.probability < coloured.probability + SETTLED:
            break
        coloured = again
    return coloured


def with_found(rows: Rows, found: Sequence[tuple[Hypothesis, Thinned]]) -> Rows:
    """Rows with columns of hypotheses, their coefficients believed as when they were weighed."""
    for one, columns in found:
        names = [f"{one.candidate.effect} {name}" for name in one.candidate.names]
        rows = rows.plus(names, columns.everywhere(rows.difference.shape[1]), one.found_std, one.found_mean)
    return rows
