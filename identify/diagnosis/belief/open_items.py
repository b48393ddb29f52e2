"""Open items: the entropy of everything that is open, now and as a run is expected to leave it [nat]."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import entr

from ...positive_definite import solve
from ...text_table import percent
from ..blocks.prediction import LINEAR, factored
from ..candidates import kind_of
from ..questions.block_answer import CREDIBLE
from ..search.selected import EXCLUDED
from ..words.naming import joined, lower, named
from .belief import Belief, Believed, Question, Stance, separations
from .gain_item import GAINS, gain_entropy, untested
from .questions import material
from .run_columns import RunColumns

UNSEEN, PARAMETERS = "effects that no run so far could show", "values of parameters"
"""What items that are no question about a misfit are called."""
NUISANCES = ("reversal", "clock")
"""Beginnings of the names of unknowns that are nobody's question."""
DRAWS = 256
"""Outcomes of a run over which entropies are averaged: to a sixteenth of how much they scatter."""
NAMED_UNSEEN = 5
"""Effects that are named, at most, of those that no run shows."""

Compared = Sequence[tuple[Question, list[Stance], np.ndarray]]
"""Questions about a misfit, the stances of their answers, and how far these are apart by the runs so far."""


class Item(NamedTuple):
    """One thing that may be open.

    Attributes:
        words: What it is about: the effects and joints of a question, `UNSEEN`, `PARAMETERS` or `GAINS`.
        entropy: Entropy of its answers [nat].
        open: Whether it has yet to be settled.
    """

    words: str
    entropy: float
    open: bool


def items(belief: Belief) -> list[Item]:
    """Everything that may be open: questions about misfits, unseen effects, parameters, drive gains."""
    found = []
    for question in belief.questions:
        if question.seen:
            words = " or ".join(_label(one) for one in question.answers if one.probability > EXCLUDED)
            found.append(Item(words, entropy(question.probabilities), not question.settled))
    unseen = sum(entropy(question.probabilities) for question in belief.questions if not question.seen)
    found.append(Item(UNSEEN, unseen, hidden(belief) > 1.0 - CREDIBLE))
    found.append(Item(PARAMETERS, parameter_entropy(belief), open_torque(belief) > 1.0))
    return [*found, Item(GAINS, gain_entropy(belief), bool(untested(belief)))]


def compared(belief: Belief) -> Compared:
    """The questions about a misfit, and how far their answers are apart so far."""
    found = []
    for question in belief.questions:
        if question.seen:
            stances = [belief.stance(question, one) for one in question.answers]
            found.append((question, stances, separations(stances, belief.gram)))
    return found


def expected_left(belief: Belief, compared: Compared, seen: np.ndarray) -> np.ndarray:
    """Entropy of each item that a run of these products of columns (c, c) leaves open, expected, (i,) [nat].

    What it settles counts for nothing: no run is made for the sake of what is certain enough already.
    """
    left = []
    for question, stances, before in compared:
        further = np.maximum(separations(stances, belief.gram + seen) - before, 0.0)
        # Whether it is there at all, a run has to show by itself; priors that are strained are so once.
        nothing = [not answer.effect for answer in question.answers]
        alone = separations(stances, seen, strain=question.own.size > 0)[:, nothing]
        further[:, nothing] = alone if question.own.size else np.maximum(further[:, nothing], alone)
        left.append(expected_entropy(question.probabilities, further, question.settling))
    unseen = [_unseen_left(belief, question, seen) for question in belief.questions if not question.seen]
    shown = 1.0 - float(np.prod([1.0 - one for one in unseen])) <= 1.0 - CREDIBLE
    left.append(0.0 if shown else sum(entropy(np.array([one, 1.0 - one])) for one in unseen))
    left.append(parameter_entropy(belief, seen) if open_torque(belief, seen) > 1.0 else 0.0)
    return np.array([*left, gain_entropy(belief, seen) if untested(belief, seen) else 0.0])


def information(belief: Belief, run: RunColumns) -> np.ndarray:
    """Products of all columns in a run, (c, c), by the weight of its rows.

    What a new body leaves unknown is fitted in it.
    """
    names = belief.search.prediction.rows.names
    gram, count = run.products(names, belief.weight)
    known = run.known(names)
    if not len(known):
        return gram
    mixed, fitted = gram[:count, count:], gram[count:, count:] + np.diag(known)
    return np.asarray(gram[:count, :count] - mixed @ solve(factored(fitted), mixed.T))


def entropy(probability: np.ndarray) -> float:
    """Of answers with these probabilities, shape (m,) [nat]."""
    return float(entr(probability).sum())


def expected_entropy(
    probability: np.ndarray, separation: np.ndarray, settling: np.ndarray | None = None
) -> float:
    """Of the same answers after a run, averaged over what it may show [nat].

    Where answer i is true and j its rival, the run multiplies the odds of i against j by a factor whose
    logarithm is normal, of mean T/2 and variance T, with T their separation.

    Args:
        probability: Before the run, shape (m,).
        separation: Row is true, column its rival, shape (m, m).
        settling: Probability from which on each answer settles the question, which then has no entropy any
            more, shape (m,); none does by default.
    """
    settling = np.full(len(probability), np.inf) if settling is None else settling
    normal = np.random.default_rng(0).normal(size=(DRAWS // 2, len(probability)))
    normal = np.concatenate([normal, -normal])
    total = 0.0
    for true in np.flatnonzero(probability):
        gained = separation[true] / 2.0 + np.sqrt(separation[true]) * normal
        gained[:, true] = 0.0
        with np.errstate(divide="ignore"):
            weight = np.log(probability) - np.clip(gained, -700.0, 700.0)
        after = np.exp(weight - np.max(weight, axis=1, keepdims=True))
        after /= after.sum(axis=1, keepdims=True)
        still = ~np.any(after >= settling, axis=1)
        total += float(probability[true]) * float((still * entr(after).sum(axis=1)).mean())
    return min(total, entropy(probability))  # of every run, but not of every draw


def parameter_entropy(belief: Belief, seen: np.ndarray | None = None) -> float:
    """Of the torque that parameters and findings leave open [nat]; behind a run with products `seen` (c, c).

    Half the sum of log(1 + s^2) over independent parts of the torque, s their standard deviation over the
    resolution: zero where it is finer, so that knowing better counts for nothing. No part is taken to be
    less sure than by the usual torque itself.
    """
    known, reach = _known(belief, seen), _parameter_reach(belief)
    return 0.5 * (_log_determinant(known + reach) - _log_determinant(known))


def open_torque(belief: Belief, seen: np.ndarray | None = None) -> float:
    """Root mean square torque that parameters leave open, over the resolution [-]; behind a run as above."""
    inverse = solve(factored(_known(belief, seen)), _parameter_reach(belief))
    return float(np.sqrt(max(np.trace(inverse), 0.0) / len(belief.weight)))


def hidden(belief: Belief) -> float:
    """Probability that some effect is there, and large enough to matter, that no run so far shows."""
    unseen = [question.answers for question in belief.questions if not question.seen]
    return 1.0 - float(np.prod([one.probability for answers in unseen for one in answers if not one.effect]))


def remaining(belief: Belief, question: Question) -> Iterator[str]:
    """Sentences about a question that no run on offer decides.

    What remains, why no motion settles it, and what would.
    """
    joints = belief.search.problem.model.robot.joints
    likely = [one for one in question.answers if one.probability > EXCLUDED]
    names = [f"{_name(one, joints)} ({percent(one.probability)})" for one in likely]
    yield f"{joined(names, 'or')}."
    share = _coincidence(belief, question)
    if share > 0.0:
        first, second = (_name(one, joints) for one in question.answers[:2])
        yield (
            f"No motion settles it: in all runs so far and on offer, {second} and the other unknowns make up "
            f"for {100 * share:.4g} % of the torque of {first}."
        )
    if cures := _cures(likely):
        yield f"What would: {joined(cures, 'or')}."


def unseen_words(belief: Belief) -> str:
    """What may be there without any run on offer showing it."""
    joints = belief.search.problem.model.robot.joints
    unseen = [question.answers for question in belief.questions if not question.seen]
    there = [one for answers in unseen for one in answers if one.effect]
    there = sorted(there, key=lambda one: -one.probability)[:NAMED_UNSEEN]
    names = [lower(f"{_name(one, joints)} ({percent(one.probability)})") for one in there]
    text = f"No run so far or on offer would show {joined(names, 'or')}."
    cures = _cures(there)
    return f"{text} What would: {joined(cures, 'or')}." if cures else text


def _unseen_left(belief: Belief, question: Question, seen: np.ndarray) -> float:
    """Probability that an unseen effect is there, after a run that does not show it either."""
    before, there = material(belief, question), question.answers[0].probability
    return there * min(material(belief, question, seen) / max(before, 1e-12), 1.0)


def _known(belief: Belief, seen: np.ndarray | None) -> np.ndarray:
    count = belief.unknowns
    matrix = belief.posterior(np.arange(count))[0] + LINEAR**2 * _parameter_reach(belief)
    return matrix if seen is None else matrix + seen[:count, :count]


def _parameter_reach(belief: Belief) -> np.ndarray:
    """`reach` of the unknowns in question."""
    names, count = belief.search.prediction.rows.names, belief.unknowns
    asked = np.array([not name.startswith(NUISANCES) for name in names])
    return np.asarray(belief.reach[:count, :count] * np.outer(asked, asked))


def _log_determinant(matrix: np.ndarray) -> float:
    factor = factored(matrix)
    return 2.0 * float(np.sum(np.log(np.diag(factor.triangle))) - np.sum(np.log(factor.scale)))


def _coincidence(belief: Belief, question: Question) -> float:
    """Share of the torque of the first answer that the second one makes up for, in all runs [-]."""
    first, second = question.answers[:2]
    if not len(first.places):
        return 0.0
    values = belief.posterior(belief.held_by(question, first))[1][-len(first.places) :]
    held, reach = belief.held_by(question, second), belief.reach
    explained = float(values @ reach[np.ix_(first.places, first.places)] @ values)
    mixed = reach[np.ix_(held, first.places)] @ values
    taken = float(mixed @ solve(factored(reach[np.ix_(held, held)]), mixed))
    return taken / explained if explained > 0.0 else 0.0


def _cures(answers: Sequence[Believed]) -> list[str]:
    """What would settle whether effects are there, each once."""
    words = [kind_of(one.effect).settled_by for one in answers if one.effect]
    return list(dict.fromkeys(filter(None, words)))


def _label(one: Believed) -> str:
    effect = one.effect.replace("_", " ") or "nothing"
    return f"{effect} ({', '.join(str(joint + 1) for joint in one.joints)})" if one.joints else effect


def _name(one: Believed, joints: tuple[str, ...]) -> str:
    return named(one.effect, one.joints, joints) if one.effect else "nothing"
