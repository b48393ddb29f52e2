"""Suspects: what is not in the model after a search and may be there, such as what explains a finding too."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.special import expit

from ...positive_definite import solve
from ..blocks.prediction import CERTAIN, factored
from ..questions.block_answer import Answer, prior_std
from ..questions.candidate import Candidate, Thinned
from ..questions.candidate_fit import FORMULA
from ..questions.question import ask
from ..results.evidence import places_of
from ..search.search import SearchResult
from ..search.selected import EXCLUDED, contradicted, log_prior

NEGLIGIBLE = EXCLUDED / 100.0
"""Probability below which an effect that nothing suggests is not asked about; a hundred of them are still
excluded together."""

Place = tuple[str, tuple[int, ...]]
"""An effect and its joints."""


class Rival(NamedTuple):
    """What else would give the torque of a finding.

    Attributes:
        answer: In the shape that comes nearest.
        odds: Logarithm of the odds of the finding against it, by no more than their torques.
    """

    answer: Answer
    odds: float


class Suspects(NamedTuple):
    """What is not in the model and may be there.

    Attributes:
        rivals: Rivals of what was found.
        left: What else may be there without being seen, each in its best shape.
        against: Logarithm of the odds of each finding, by its number, against effects on joints.
    """

    rivals: tuple[Answer, ...]
    left: tuple[Answer, ...]
    against: dict[int, dict[Place, float]]

    @property
    def every(self) -> tuple[Answer, ...]:
        """In the order of their columns."""
        return self.rivals + self.left


def suspects_of(search: SearchResult) -> Suspects:
    """Alternatives of the findings, and what else gives their torque; then all that was not found."""
    others = {place: _rivals(search, place) for place in range(len(search.selected))}
    found = [answer for one in search.selected for answer, _ in one.elsewhere]
    found += [rival.answer for own in others.values() for rival in own]
    by_key = {one.candidate.key: one for one in reversed(found)}
    left = [
        one
        for one in search.left
        if one.candidate.key not in by_key and unseen_probability(one, search.total) >= NEGLIGIBLE
    ]
    against = {place: {place_of(rival.answer): rival.odds for rival in own} for place, own in others.items()}
    return Suspects(tuple(by_key.values()), tuple(left), against)


def unseen_probability(one: Answer, total: float) -> float:
    """That an effect which was not found is there; zero where runs held out contradict it."""
    return 0.0 if contradicted(one) else float(expit(one.odds + log_prior(one, total)))


def place_of(one: Answer) -> Place:
    """Effect and joints of an answer."""
    return one.candidate.effect, one.candidate.joints


def _rivals(search: SearchResult, place: int) -> list[Rival]:
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

    def touches(candidate: Candidate, joints: np.ndarray) -> bool:
        return candidate.key != here.candidate.key and bool(np.intersect1d(joints, here.columns.joints).size)

    for candidate, columns in search.problem.pairs(touches):
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
