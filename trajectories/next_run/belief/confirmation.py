"""Confirmation: a finding predicts a run that it was not found in."""

import numpy as np

from exidyn.identify.diagnosis.blocks.block_likelihood import log_probability
from exidyn.identify.diagnosis.blocks.prediction import Prediction, factored
from exidyn.identify.diagnosis.results.evidence import places_of
from exidyn.identify.diagnosis.search.search import SearchResult
from exidyn.identify.diagnosis.search.selected import CERTAIN_ODDS
from exidyn.identify.positive_definite import solve


def confirmed(search: SearchResult, place: int) -> bool:
    """Whether some run is more probable with a finding of the others by 19 to 1, and the rest not less so.

    Blocks of one motion share what it does not show, so that they are no proof of each other.
    """
    gains = gained(search, place)
    best = max(gains, default=0.0)
    return best > CERTAIN_ODDS and sum(gains) - best > -CERTAIN_ODDS


def gained(search: SearchResult, place: int) -> list[float]:
    """Logarithm of how much more probable each run is with a finding, both fitted to the other runs."""
    prediction = search.prediction
    if len(prediction.rows.runs) < 2:
        return []
    every = np.arange(len(prediction.rows.names))
    without = np.setdiff1d(every, places_of(search, place))
    starts = np.array([piece.start for piece in prediction.blocks.rows])
    return [
        _gain(prediction, (starts >= rows.start) & (starts < rows.stop), every, without)
        for rows in prediction.rows.runs
    ]


def _gain(prediction: Prediction, left_out: np.ndarray, every: np.ndarray, without: np.ndarray) -> float:
    gram, right = prediction.sums.whole(prediction.weighting.weight, len(every))
    matrix = gram[~left_out].sum(axis=0) + np.diag(prediction.precision)
    right = right[~left_out].sum(axis=0) + prediction.precision * prediction.rows.mean
    share, counts = prediction.weighting.independent, prediction.sums.counts[left_out]
    found = []
    for held in (every, without):
        values = np.zeros(len(every))
        values[held] = solve(factored(matrix[np.ix_(held, held)]), right[held])
        errors = prediction.sums.errors(np.tile(values, (len(left_out), 1)))[left_out]
        found.append(float(log_probability(share * errors, share * counts).sum()))
    return found[0] - found[1]
