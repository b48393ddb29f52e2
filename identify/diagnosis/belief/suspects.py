"""Suspects: effects that may be there after a search without being findings, such as rivals of findings."""

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
"""Probability below which an effect without evidence raises no question; even a hundred of these together
stay excluded."""

Place = tuple[str, tuple[int, ...]]
"""An effect and its joints."""


class Suspects(NamedTuple):
    """Effects that are not in the model and may be there."""

    rivals: tuple[Answer, ...]  # rivals of the findings
    unseen: tuple[Answer, ...]  # other effects that may be there without being seen, each in its best shape
    # log odds of each finding, by its index, against effects on joints
    against: dict[int, dict[Place, float]]

    @property
    def every(self) -> tuple[Answer, ...]:
        """All suspects in the order of their columns."""
        return self.rivals + self.unseen


def suspects_of(search: SearchResult) -> Suspects:
    """Rivals of the findings, by blocks or by their torque, then all other hypotheses that may be there."""
    rivals = {place: _rivals(search, place) for place in range(len(search.selected))}
    answers = [answer for finding in search.selected for answer, _ in finding.elsewhere]
    answers += [rival for group in rivals.values() for rival, _ in group]
    by_key = {answer.candidate.key: answer for answer in reversed(answers)}
    unseen = [
        answer
        for answer in search.left
        if answer.candidate.key not in by_key and unseen_probability(answer, search.total) >= NEGLIGIBLE
    ]
    against = {place: {place_of(rival): odds for rival, odds in group} for place, group in rivals.items()}
    return Suspects(tuple(by_key.values()), tuple(unseen), against)


def unseen_probability(answer: Answer, total: float) -> float:
    """Probability that an effect is there although it was not found; zero if held-out runs contradict it."""
    return 0.0 if contradicted(answer) else float(expit(answer.odds + log_prior(answer, total)))


def place_of(answer: Answer) -> Place:
    """Effect and joints of an answer."""
    return answer.candidate.effect, answer.candidate.joints


def _rivals(search: SearchResult, place: int) -> list[tuple[Answer, float]]:
    """Rivals of a finding in their closest shapes, and the log odds of the finding against each by torque.

    The torque of the finding does not exclude them, and physics allows them with the other findings. Torque
    that the model's unknowns reproduce without a rival does not count in its favor.
    """
    finding = search.selected[place]
    if finding.once:
        return []
    closest: dict[object, tuple[float, Candidate, Thinned]] = {}
    for weight, candidate, columns in _similar(search, place):
        weight *= candidate.prior / finding.answer.candidate.prior
        if weight > max(EXCLUDED, closest.get(candidate.key, (0.0,))[0]):
            closest[candidate.key] = weight, candidate, columns
    others = [other.answer for other in search.selected if other is not finding]
    prediction = search.problem.prediction(others, search.prediction)
    allowed = ask(prediction, [(candidate, columns) for _, candidate, columns in closest.values()])
    return [(answer, -float(np.log(closest[answer.candidate.key][0]))) for answer in allowed]


def _similar(search: SearchResult, place: int) -> Iterator[tuple[float, Candidate, Thinned]]:
    """Probability of a finding's torque with every shape of all other hypotheses on the same joints.

    It is relative to that with the finding itself, minus that with the other unknowns alone.
    """
    prediction, here = search.prediction, search.selected[place].answer
    rows, finding_places = prediction.rows, places_of(search, place)
    weight = np.sqrt(prediction.weighting.weight[prediction.blocks.number] * rows.weight)
    torque = weight * (rows.columns[:, :, finding_places] @ prediction.values[finding_places])
    others = np.setdiff1d(np.arange(len(rows.names)), finding_places)
    known = weight[:, :, None] * rows.columns[:, :, others]
    flat = known.reshape(-1, len(others))
    precision = np.maximum(rows.std[others], CERTAIN) ** -2.0
    factor = factored(flat.T @ flat + np.diag(precision))
    along = flat.T @ torque.ravel()
    alone, power = solve(factor, along), float(np.sum(torque**2))

    def probability(strained: float, separated: float) -> float:
        unexplained = max(separated - strained, 0.0)
        return float(np.exp(-0.5 * (strained + unexplained / (1.0 + FORMULA**2 * power))))

    separated = power - float(along @ alone)
    without = probability(float(precision @ alone**2), separated)

    def touches(candidate: Candidate, joints: np.ndarray) -> bool:
        return candidate.key != here.candidate.key and bool(np.intersect1d(joints, here.columns.joints).size)

    for candidate, columns in search.problem.pairs(touches):
        values = (weight[:, columns.joints, None] * columns.values).reshape(-1, columns.values.shape[2])
        mixed = known[:, columns.joints].reshape(len(values), -1).T @ values
        prior = np.maximum(prior_std(candidate, columns), CERTAIN) ** -2.0
        decrease = solve(factor, mixed)
        matrix = values.T @ values + np.diag(prior) - mixed.T @ decrease
        right = values.T @ torque[:, columns.joints].ravel() - mixed.T @ alone
        coefficients = solve(factored(matrix), right)
        unknowns = alone - decrease @ coefficients
        strained = float(precision @ unknowns**2 + prior @ coefficients**2)
        with_candidate = probability(strained, separated - float(right @ coefficients))
        yield with_candidate - without, candidate, columns
