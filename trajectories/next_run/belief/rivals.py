"""Rivals: what else would give the torque of a finding, whatever its blocks say."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from exidyn.identify.diagnosis.blocks.prediction import CERTAIN, factored
from exidyn.identify.diagnosis.questions.block_answer import Answer, prior_std
from exidyn.identify.diagnosis.questions.candidate import Candidate, Thinned
from exidyn.identify.diagnosis.questions.candidate_fit import FORMULA
from exidyn.identify.diagnosis.questions.question import ask
from exidyn.identify.diagnosis.results.evidence import places_of
from exidyn.identify.diagnosis.search.search import SearchResult
from exidyn.identify.diagnosis.search.selected import EXCLUDED
from exidyn.identify.positive_definite import solve


class Rival(NamedTuple):
    """What else would give the torque of a finding.

    Attributes:
        answer: In the shape that comes nearest.
        odds: Logarithm of the odds of the finding against it, by no more than their torques.
    """

    answer: Answer
    odds: float


def rivals(search: SearchResult, place: int) -> list[Rival]:
    """What physics allows beside the other findings, and what by its torque alone is not excluded.

    Each hypothesis once. What the model's own unknowns make up for without it speaks for none of them.
    """
    one = search.selected[place]
    if one.once:
        return []
    found: dict[object, tuple[float, Candidate, Thinned]] = {}
    for weight, candidate, columns in _near(search, place):
        weight *= candidate.prior / one.answer.candidate.prior
        if weight > max(EXCLUDED, found.get(candidate.key, (0.0,))[0]):
            found[candidate.key] = weight, candidate, columns
    others = [other.answer for other in search.selected if other is not one]
    prediction = search.problem.prediction(others, search.prediction)
    allowed = ask(prediction, [(candidate, columns) for _, candidate, columns in found.values()])
    return [Rival(answer, -float(np.log(found[answer.candidate.key][0]))) for answer in allowed]


def _near(search: SearchResult, place: int) -> Iterator[tuple[float, Candidate, Thinned]]:
    """How probable the torque of a finding is by every shape of all other hypotheses on the same joints.

    Over that of the finding itself, and less than by the other unknowns alone.
    """
    prediction, here = search.prediction, search.selected[place].answer
    rows, own = prediction.rows, places_of(search, place)
    weight = np.sqrt(prediction.weighting.weight[prediction.blocks.number] * rows.weight)
    torque = weight * (rows.columns[:, :, own] @ prediction.values[own])
    rest = np.setdiff1d(np.arange(len(rows.names)), own)
    known = weight[:, :, None] * rows.columns[:, :, rest]
    flat = known.reshape(-1, len(rest))
    strain = np.maximum(rows.std[rest], CERTAIN) ** -2.0
    factor = factored(flat.T @ flat + np.diag(strain))
    along = flat.T @ torque.ravel()
    alone, power = solve(factor, along), float(np.sum(torque**2))

    def probability(strained: float, separated: float) -> float:
        left = max(separated - strained, 0.0)
        return float(np.exp(-0.5 * (strained + left / (1.0 + FORMULA**2 * power))))

    separated = power - float(along @ alone)
    nothing = probability(float(strain @ alone**2), separated)
    for candidate, columns in search.problem.asked:
        shared = np.intersect1d(columns.joints, here.columns.joints)
        if candidate.key == here.candidate.key or not shared.size:
            continue
        values = (weight[:, columns.joints, None] * columns.values).reshape(-1, columns.values.shape[2])
        mixed = known[:, columns.joints].reshape(len(values), -1).T @ values
        prior = np.maximum(prior_std(candidate, columns), CERTAIN) ** -2.0
        apart = solve(factor, mixed)
        matrix = values.T @ values + np.diag(prior) - mixed.T @ apart
        right = values.T @ torque[:, columns.joints].ravel() - mixed.T @ alone
        taken = solve(factored(matrix), right)
        unknowns = alone - apart @ taken
        strained = float(strain @ unknowns**2 + prior @ taken**2)
        there = probability(strained, separated - float(right @ taken))
        yield there - nothing, candidate, columns
