"""Refused: a finding whose formula the data contradict, or which may be part of something without a name."""

import numpy as np

from exidyn.identify.diagnosis.diagnose import noise_floor
from exidyn.identify.diagnosis.questions.candidate_fit import FORMULA, STRANGE
from exidyn.identify.diagnosis.results.evidence import explained, places_of
from exidyn.identify.diagnosis.results.remainder import rms
from exidyn.identify.diagnosis.search.search import SearchResult


def refused(search: SearchResult, place: int) -> bool:
    """Whether beside all that was found a coefficient is where physics excludes it.

    When it was asked for, it was not: what it left counted as noise, beside which the prior held it.
    """
    columns = search.selected[place].answer.columns
    values, known = search.prediction.values[places_of(search, place)], columns.mean != 0.0
    return bool(np.any(np.abs(values - columns.mean)[known] > STRANGE * columns.std[known]))


def unnamed_odds(search: SearchResult, place: int) -> float:
    """Odds that a finding is part of something without a name.

    What is left beyond noise, and beyond the errors of the formulas found, is there and has no name. A misfit
    that it shares with a finding is as much the one's as the other's: their odds are those of their squared
    torques, on the joint where the finding stands out most. Without noise that was measured nothing is known.
    """
    prediction = search.prediction
    noise, rested = noise_floor(search.problem.runs)
    if not rested:
        return 0.0
    weight = prediction.rows.weight
    torques = np.array([rms(one, weight) for one in explained(search, prediction.rows, prediction.values)])
    formulas = np.sum((FORMULA * torques) ** 2, axis=0)
    left = np.maximum(rms(prediction.residual, weight) ** 2 - noise**2 - formulas, 0.0)
    own = torques[place] > 0.0
    return float(np.min(left[own] / torques[place][own] ** 2, initial=np.inf)) if np.any(own) else 0.0
