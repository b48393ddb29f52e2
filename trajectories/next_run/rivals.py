"""Rivals: what else would give the torque of a finding, whatever its blocks say."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from exidyn.identify.diagnosis.blocks.prediction import CERTAIN, factored, solve
from exidyn.identify.diagnosis.questions.block_answer import Answer, prior_std
from exidyn.identify.diagnosis.questions.candidate import Candidate, Thinned
from exidyn.identify.diagnosis.questions.candidate_fit import FORMULA
from exidyn.identify.diagnosis.questions.question import ask
from exidyn.identify.diagnosis.results.evidence import places_of
from exidyn.identify.diagnosis.search.search import SearchResult
from exidyn.identify.diagnosis.search.selected import EXCLUDED


class Rival(NamedTuple):
    """What else would give the torque of a finding.

    Attributes:
        answer: In the shape that comes nearest.
        odds: Logarithm of the odds of the finding against it, by no more than their torques.
    """

    answer: Answer
    odds: float


class Near(NamedTuple):
    """A shape of a hypothesis, and what speaks against it: half a chi-squared."""

    loss: float
    candidate: Candidate
    columns: Thinned


def rivals(search: SearchResult, place: int) -> list[Rival]:
    """What physics allows beside the other findings, and what by its torque alone is not excluded.

    A hypothesis counts with the mean probability of its shapes, as in the diagnosis.
    """
    one = search.selected[place]
    if one.once:
        return []
    shapes: dict[object, list[Near]] = {}
    for near in _near(search, place):
        shapes.setdefault(near.candidate.key, []).append(near)
    here, own = one.answer.candidate, _loss(shapes.pop(one.answer.candidate.key, []))
    found = {}
    for key, every in shapes.items():
        first = min(every, key=lambda near: near.loss)
        odds = _loss(every) - own + float(np.log(here.prior / first.candidate.prior))
        if odds < -np.log(EXCLUDED):
            found[key] = first, odds
    others = [other.answer for other in search.selected if other is not one]
    prediction = search.problem.prediction(others, search.prediction)
    allowed = ask(prediction, [(first.candidate, first.columns) for first, _ in found.values()])
    return [Rival(answer, found[answer.candidate.key][1]) for answer in allowed]


def _loss(shapes: Sequence[Near]) -> float:
    """Of a hypothesis; nothing where it has no shapes but the one that was found."""
    return -float(np.logaddexp.reduce([-one.loss for one in shapes]) - np.log(len(shapes))) if shapes else 0.0


def _near(search: SearchResult, place: int) -> Iterator[Near]:
    """What speaks against every shape of all hypotheses on the same joints, by the torque of a finding."""
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
    for candidate, columns in search.problem.asked:
        if not np.intersect1d(columns.joints, here.columns.joints).size:
            continue
        values = weight[:, columns.joints, None] * columns.values
        mixed = np.einsum("rnb,rnp->bp", known[:, columns.joints], values)
        prior = np.maximum(prior_std(candidate, columns), CERTAIN) ** -2.0
        apart = solve(factor, mixed)
        matrix = np.einsum("rnp,rnq->pq", values, values) + np.diag(prior) - mixed.T @ apart
        right = np.einsum("rnp,rn->p", values, torque[:, columns.joints]) - mixed.T @ alone
        taken = solve(factored(matrix), right)
        unknowns = alone - apart @ taken
        strained = float(strain @ unknowns**2 + prior @ taken**2)
        left = max(power - float(along @ alone) - float(right @ taken) - strained, 0.0)
        yield Near(0.5 * (strained + left / (1.0 + FORMULA**2 * power)), candidate, columns)
