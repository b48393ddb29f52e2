"""Held out: runs that were not fitted, predicted with and without what was found."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..model import Model
from .candidate import Thinned
from .driven import Driven
from .hypothesis import Hypothesis
from .nuisances import CLOCK, with_nuisances
from .remainder import rms
from .rows import Rows, model_rows
from .search import Searched
from .solution import CERTAIN, Share, Solution, marginal
from .solving import with_found
from .whitening import Whitening

FREE = ("Fv", "Fc", "Off", "reversal", CLOCK)
"""Unknowns that are fitted even where the model is taken at its word: friction and offsets are guesses."""


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Runs that were not fitted.

    Attributes:
        runs: With the torque of the fitted model.
        rows: Of these runs, with a column for everything that was found.
        whitening: The one that the fit used.
    """

    runs: tuple[Driven, ...]
    rows: Rows
    whitening: Whitening

    @classmethod
    def of(cls, model: Model, found: Searched, runs: Sequence[Driven]) -> "HeldOut | None":
        """The same columns over other runs; None without any."""
        if not runs:
            return None
        runs = [found.scene.known.on(run) for run in runs]
        rows = with_nuisances(model_rows(model, runs), model, runs)
        hypotheses = [one.hypothesis for one in found.found]
        count = sum(run.rows for run in runs)
        pairs = [(one, _columns(one, runs, count)) for one in hypotheses]
        rows = with_found(rows, pairs)
        return cls(tuple(runs), rows, found.solution.whitening.elsewhere(rows.weight, rows.runs))

    def gain(self, found: Searched, place: int) -> float:
        """Twice the logarithm of how much likelier one finding makes these runs, after those fitted.

        What is foretold is not one torque but what all unknowns allow, as far as the fitted runs and beliefs
        leave them open, with and without the finding.
        """
        own = columns_of(found, place)
        without = found.rows.relaxed(own, np.full(len(own), CERTAIN))
        own_shares, both = self.solution.shares, found.solution.shares
        return 2.0 * (foretold(both, own_shares, found.rows) - foretold(both, own_shares, without))

    def further(self, found: Searched, hypothesis: Hypothesis) -> float:
        """The same of a hypothesis that is not among the findings."""
        fitted, columns = found.solution, _columns(hypothesis, self.runs, len(self.rows.difference))
        wider = with_found(found.rows, [(hypothesis, hypothesis.columns)])
        own = with_found(self.rows, [(hypothesis, columns)])
        both = Solution(wider, fitted.whitening).shares, Solution(own, self.whitening).shares
        with_it = foretold(*both, wider)
        return 2.0 * (with_it - foretold(fitted.shares, self.solution.shares, found.rows))

    @cached_property
    def solution(self) -> Solution:
        """Of these runs alone."""
        return Solution(self.rows, self.whitening)

    def residuals(self, found: Searched) -> tuple[np.ndarray, np.ndarray]:
        """Root mean squares before and after, each (n,) [N m].

        Before, the model is taken at its word but for friction and offsets.
        """
        return tuple(  # type: ignore[return-value]
            rms(self.rows.difference - self.rows.columns @ values, self.rows.weight)
            for values in (at_its_word(found), found.solution.values)
        )


def foretold(fitted: Sequence[Share], others: Sequence[Share], rows: Rows) -> float:
    """Logarithm of the probability of other rows after those fitted, with the beliefs of given rows."""
    known = 1.0 / np.maximum(rows.std, CERTAIN) ** 2
    return marginal([*fitted, *others], known, rows.mean)[1] - marginal(fitted, known, rows.mean)[1]


def _columns(one: Hypothesis, runs: Sequence[Driven], count: int) -> Thinned:
    """Its columns over runs; zero where these did not record what it takes."""
    columns = Thinned.of(one.candidate, runs)
    still = np.zeros((count, *one.columns.values.shape[1:]))
    return replace(one.columns, values=still) if columns.empty else columns


def at_its_word(found: Searched) -> np.ndarray:
    """Unknowns (b,) of a model taken at its word but for friction and offsets, without any finding."""
    rows = found.believed.rows
    free = np.array([name.startswith(FREE) for name in rows.names])
    std = np.where(free, rows.std, CERTAIN)
    word = Solution(rows.relaxed(range(len(std)), std), found.believed.whitening).values
    return np.append(word, np.zeros(len(found.rows.names) - len(word)))


def columns_of(found: Searched, place: int) -> list[int]:
    """Places of a finding's coefficients among all unknowns."""
    counts = [len(one.hypothesis.candidate.names) for one in found.found]
    start = len(found.rows.names) - sum(counts[place:])
    return list(range(start, start + counts[place]))
