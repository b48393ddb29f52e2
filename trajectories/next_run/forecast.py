"""Forecast: by how much a run is expected to lower the entropy of everything that is open."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from exidyn.identify.diagnosis.blocks.prediction import Factor, factored, solve
from exidyn.identify.diagnosis.questions.comparison import LINEAR
from exidyn.identify.diagnosis.search.selected import EXCLUDED

from ..discrimination.distinction import HOUR, SURE
from .belief import NUISANCES, Belief, Believed, Question, all_columns, products
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


def separations(belief: Belief, question: Question, seen: Information) -> np.ndarray:
    """How far each answer (row) is then from being explained by each other one (column), shape (m, m)."""
    answers = question.answers
    values = [_values(belief, question, one) for one in answers]
    found = np.zeros((len(answers), len(answers)))
    for rival, other in enumerate(answers):
        held = belief.held_by(question, other)
        columns = seen.gram[:, held]
        factor = factored(belief.posterior(held)[0] + columns[held])

        def left(ways: np.ndarray, columns: np.ndarray = columns, factor: Factor = factor) -> np.ndarray:
            """Products of all columns with what the rival leaves of torques (c, k), shape (c, k)."""
            return np.asarray(seen.gram @ ways - columns @ solve(factor, columns.T @ ways))

        for true, one in enumerate(answers):
            if true != rival:
                found[true, rival] = _separation(
                    belief, question, one, values[true] - values[rival], left, seen
                )
    return found


def _separation(
    belief: Belief,
    question: Question,
    one: Believed,
    apart: np.ndarray,
    left: Callable[[np.ndarray], np.ndarray],
    seen: Information,
) -> float:
    """Of a true answer from a rival whose coefficients are `apart` (c,), averaged over its own spread."""
    ways = apart[:, None]
    if len(one.places):
        followed, covariance = belief.spread(question, one)
        spread = np.zeros((len(apart), len(one.places)))
        spread[belief.held_by(question, one)] = followed @ np.linalg.cholesky(covariance)
        ways = np.concatenate([ways, spread], axis=1)
    total, explained = float(np.sum(ways * left(ways))), float(np.sum(ways * (seen.gram @ ways)))
    # Current sensors are linear to a few per cent, and what differs by less tells nothing.
    return total if total > LINEAR**2 * explained else 0.0


def _values(belief: Belief, question: Question, one: Believed) -> np.ndarray:
    """All columns' coefficients if an answer is true, shape (c,)."""
    held, values = belief.held_by(question, one), np.zeros(len(belief.gram))
    values[held] = belief.posterior(held)[1]
    return values


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
    (triangle, _), scale = factored(matrix)
    return 2.0 * float(np.sum(np.log(np.diag(triangle))) - np.sum(np.log(scale)))


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


def _left(belief: Belief, seen: Information) -> np.ndarray:
    """Entropy of each item after a run, expected, shape (i,)."""
    asked, unseen = [], 0.0
    for question in belief.questions:
        left = expected_entropy(question.probabilities, separations(belief, question, seen))
        if question.seen:
            asked.append(left)
        else:
            unseen += left
    return np.array([*asked, unseen, parameter_entropy(belief, seen)])


def forecast(belief: Belief, offer: Offer, run: RunColumns) -> Forecast:
    """What is expected of a run on offer."""
    seen, before = information(belief, run), items(belief)
    left = _left(belief, seen)
    gained = sum(one.entropy - after for one, after in zip(before, left, strict=True) if one.open)
    return Forecast(offer, left, _left(belief, seen.times(HOUR / offer.motion)), float(gained))


def forecasts(belief: Belief, offers: Sequence[Offer], runs: Sequence[RunColumns]) -> list[Forecast]:
    """Of all offers, the one that gains most per second first."""
    found = [forecast(belief, offer, run) for offer, run in zip(offers, runs, strict=True)]
    return sorted(found, key=lambda one: -one.rate)
