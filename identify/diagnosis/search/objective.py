"""Objective: how much more probable the fitted blocks are with one list of findings than with another."""

from collections.abc import Sequence

import numpy as np

from ..blocks.block_likelihood import strain
from ..blocks.prediction import Prediction
from ..questions.block_answer import CERTAIN_ODDS
from .problem import Problem
from .selected import Selected, answers_of, log_prior


def advantage(problem: Problem, after: Sequence[Selected], before: Sequence[Selected], total: float) -> float:
    """Log odds of one list of findings against another, from fitted blocks, priors and shape costs.

    A finding costs the log odds at which it is credible, so that no list gains by findings that are not.
    """
    new, old = (problem.prediction(answers_of(findings)) for findings in (after, before))
    # Both at the same share of independent rows: the better model leaves the whiter residual.
    independent = np.maximum(new.weighting.independent, old.weighting.independent)
    gain = new.log_probability(new.errors, independent) - old.log_probability(old.errors, independent)
    relief = _strain(old) - _strain(new)
    costs = [sum(_cost(finding, total) for finding in findings) for findings in (after, before)]
    return float(gain[problem.blocks.fitted].sum()) + relief - costs[0] + costs[1]


def _strain(prediction: Prediction) -> float:
    """Loss in log probability of the stated unknowns, which deviate from their priors."""
    rows, known = prediction.rows, prediction.stated
    apart = (prediction.values - rows.mean)[known] / rows.std[known]
    return strain(apart, rows.bounded[known])


def _cost(finding: Selected, total: float) -> float:
    """Loss in log probability that a finding must make up for."""
    return finding.answer.cost - log_prior(finding.answer, total) + CERTAIN_ODDS * (not finding.once)
