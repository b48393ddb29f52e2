"""Refused: a finding whose formula the data contradict, or which may be part of something without a name."""

import numpy as np

from exidyn.identify.diagnosis import Diagnosis
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


def nameless(diagnosis: Diagnosis, search: SearchResult) -> np.ndarray:
    """Squared torque of each joint that is left and depends on something, shape (n,) [(N m)^2].

    Beyond noise and the errors of the formulas found. What depends on nothing that was recorded is taken for
    noise of drives that move.
    """
    assert diagnosis.evidence is not None
    weight, noise = search.prediction.rows.weight, np.asarray(diagnosis.evidence.noise)
    formulas = np.sum((FORMULA * _torques(search)) ** 2, axis=0)
    left = np.maximum(rms(search.prediction.residual, weight) ** 2 - noise**2 - formulas, 0.0)
    dependent = [one.joint for one in diagnosis.remainders if one.predictable]
    return np.where(np.isin(np.arange(len(left)), dependent), left, 0.0)


def nameless_odds(search: SearchResult, place: int, left: np.ndarray) -> float:
    """What is left without a name (n,) [(N m)^2], over what a finding explains: it may be part of that.

    Of their squared torques, on the joint where the finding stands out most. Above one, most of the misfit is
    not explained.
    """
    torque = _torques(search)[place]
    own = torque > 0.0
    return float(np.min(left[own] / torque[own] ** 2)) if np.any(own) else 0.0


def _torques(search: SearchResult) -> np.ndarray:
    """Root mean square torque of each finding, shape (f, n) [N m]."""
    prediction = search.prediction
    every = explained(search, prediction.rows, prediction.values)
    return np.array([rms(one, prediction.rows.weight) for one in every]).reshape(-1, prediction.joints)
