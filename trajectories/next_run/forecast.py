"""Forecast: by how much a run is expected to lower the entropy of everything that is open."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from exidyn.identify.diagnosis.blocks.prediction import LINEAR, factored
from exidyn.identify.diagnosis.search.selected import EXCLUDED
from exidyn.identify.positive_definite import solve

from ..discrimination.distinction import HOUR, SURE
from .belief.after_search import all_columns, products
from .belief.belief import NUISANCES, Belief, Believed, Question
from .belief.questions import material
from .belief.separations import Stance, separations
from .columns import RunColumns
from .entropy import entropy, expected_entropy
from .offer import Offer

UNSEEN, PARAMETERS = "effects that no run so far could show", "values of parameters"
"""What items that are no question about a misfit are called."""


class Information(NamedTuple):
    """What a run contains of all columns, (c, c): by the weight of its rows."""

    gram: np.ndarray

    def times(self, runs: float) -> "Information":
        """Of so many runs."""
        return Information(runs * self.gram)


class Item(NamedTuple):
    """One thing that may be open.

    Attributes:
        words: What it is about: the effects and joints of a question, "unseen effects", "parameters".
        entropy: Of it [nat].
        open: Whether it has yet to be settled.
    """

    words: str
    entropy: float
    open: bool


@dataclass(frozen=True, eq=False)
class Forecast:
    """What is expected of a run.

    Attributes:
        offer: The run.
        left: Entropy of each item behind it, expected, shape (i,) [nat].
        left_hour: The same behind an hour of it.
        gained: By how much less what is open is behind it [nat].
    """

    offer: Offer
    left: np.ndarray
    left_hour: np.ndarray
    gained: float

    @property
    def rate(self) -> float:
        """Information that is gained in a second [nat/s]."""
        return self.gained / self.offer.seconds


def information(belief: Belief, run: RunColumns) -> Information:
    """Of a run on offer; what a new body leaves unknown is fitted in it."""
    every, more, known = all_columns(run, belief.search.prediction.rows.names)
    count = every.shape[2]
    whole = products(np.concatenate([every, more], axis=2), run.rows.weight * belief.weight)
    if not len(known):
        return Information(whole)
    mixed, own = whole[:count, count:], whole[count:, count:] + np.diag(known)
    return Information(whole[:count, :count] - mixed @ solve(factored(own), mixed.T))


def parameter_entropy(belief: Belief, more: Information | None = None) -> float:
    """Of the torque that the values of the model's parameters and findings leave open [nat].

    Half the sum of log(1 + s^2) over independent parts of the torque, s their standard deviation over the
    resolution: zero where it is finer, so that knowing better counts for nothing. No part is taken to be
    less sure than by the usual torque itself.
    """
    known = _known(belief, more)
    reach = _own_reach(belief)
    return 0.5 * (_log_determinant(known + reach) - _log_determinant(known))


def open_torque(belief: Belief) -> float:
    """Root mean square torque that parameters leave open, over the resolution [-]."""
    n = len(belief.weight)
    inverse = solve(factored(_known(belief, None)), _own_reach(belief))
    return float(np.sqrt(max(np.trace(inverse), 0.0) / n))


def _known(belief: Belief, more: Information | None) -> np.ndarray:
    every = np.arange(belief.unknowns)
    matrix = belief.posterior(every)[0] + LINEAR**2 * _own_reach(belief)
    return matrix if more is None else matrix + more.gram[: len(every), : len(every)]


def _own_reach(belief: Belief) -> np.ndarray:
    """`reach` of the unknowns in question."""
    names, count = belief.search.prediction.rows.names, belief.unknowns
    asked = np.array([not name.startswith(NUISANCES) for name in names])
    return np.asarray(belief.reach[:count, :count] * np.outer(asked, asked))


def _log_determinant(matrix: np.ndarray) -> float:
    factor = factored(matrix)
    return 2.0 * float(np.sum(np.log(np.diag(factor.triangle))) - np.sum(np.log(factor.scale)))


def items(belief: Belief) -> list[Item]:
    """Everything that may be open: each question about a misfit, all unseen effects, all parameters."""
    found = []
    for question in belief.questions:
        if question.seen:
            settled = question.answers[0].probability >= SURE and question.answers[0].effect
            words = " or ".join(_named(one) for one in question.answers if one.probability > EXCLUDED)
            found.append(Item(words, entropy(question.probabilities), not settled))
    unseen = sum(entropy(question.probabilities) for question in belief.questions if not question.seen)
    found.append(Item(UNSEEN, unseen, hidden(belief) > 1.0 - SURE))
    return [*found, Item(PARAMETERS, parameter_entropy(belief), open_torque(belief) > 1.0)]


def _named(one: Believed) -> str:
    effect = one.effect.replace("_", " ") or "nothing"
    return f"{effect} ({', '.join(str(joint + 1) for joint in one.joints)})" if one.joints else effect


def hidden(belief: Belief) -> float:
    """Probability that some effect is there, and large enough to matter, that no run so far shows."""
    absent = [
        one.probability
        for question in belief.questions
        if not question.seen
        for one in question.answers
        if not one.effect
    ]
    return 1.0 - float(np.prod(absent))


Asked = Sequence[tuple[Question, list[Stance], np.ndarray]]
"""Questions about a misfit, the stances of their answers, and how far these are apart by the runs so far."""


def _left(belief: Belief, asked: Asked, seen: Information) -> np.ndarray:
    """Entropy of each item after a run, expected, shape (i,)."""
    left = []
    for question, stances, before in asked:
        further = np.maximum(separations(stances, belief.gram + seen.gram) - before, 0.0)
        # Whether it is there at all, a run has to show by itself.
        nothing = [not answer.effect for answer in question.answers]
        further[:, nothing] = separations(stances, seen.gram)[:, nothing]
        left.append(expected_entropy(question.probabilities, further))
    unseen = sum(
        _hidden_entropy(belief, question, seen) for question in belief.questions if not question.seen
    )
    return np.array([*left, unseen, parameter_entropy(belief, seen)])


def _hidden_entropy(belief: Belief, question: Question, seen: Information) -> float:
    """Of whether an unseen effect is there, after a run that does not show it either."""
    before, there = material(belief, question), question.answers[0].probability
    left = there * min(material(belief, question, seen.gram) / max(before, 1e-12), 1.0)
    return entropy(np.array([left, 1.0 - left]))


def forecast(belief: Belief, asked: Asked, offer: Offer, run: RunColumns) -> Forecast:
    """What is expected of a run on offer."""
    seen, before = information(belief, run), items(belief)
    left = _left(belief, asked, seen)
    gained = sum(one.entropy - after for one, after in zip(before, left, strict=True) if one.open)
    # No less than its first run, however alike torques come to be beside all that an hour shows.
    hour = np.minimum(left, _left(belief, asked, seen.times(HOUR / offer.motion)))
    return Forecast(offer, left, hour, float(gained))


def forecasts(belief: Belief, offers: Sequence[Offer], runs: Sequence[RunColumns]) -> list[Forecast]:
    """Of all offers, the one that gains most per second first."""
    asked = []
    for question in belief.questions:
        if question.seen:
            stances = [belief.stance(question, one) for one in question.answers]
            asked.append((question, stances, separations(stances, belief.gram)))
    found = [forecast(belief, asked, offer, run) for offer, run in zip(offers, runs, strict=True)]
    return sorted(found, key=lambda one: -one.rate)
