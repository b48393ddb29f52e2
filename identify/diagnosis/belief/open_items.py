"""Open items: the entropy of everything that is open, now and expected after a further run [nat]."""

from collections.abc import Iterator, Sequence
from enum import Enum
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
"""Names of the items that are not questions about a misfit."""
NUISANCES = ("reversal", "clock")
"""Prefixes of the names of unknowns that are not of interest."""
DRAWS = 256
"""Number of simulated outcomes of a run over which entropies are averaged."""
NAMED_UNSEEN = 5
"""Maximum number of unseen effects that are named."""

Compared = Sequence[tuple[Question, list[Stance], np.ndarray]]
"""Questions about a misfit, the stances of their answers, and their separations by the runs so far."""


class Subject(Enum):
    """What an item is about."""

    QUESTION = 1
    UNSEEN = 2
    PARAMETERS = 3
    GAINS = 4


class Item(NamedTuple):
    """One thing that may be open."""

    words: str  # subject of the item in words, such as effects and joints of a question
    entropy: float  # entropy of its answers [nat]
    open: bool  # whether it is still undecided
    subject: Subject = Subject.QUESTION  # what it is about


def items(belief: Belief) -> list[Item]:
    """Everything that may be open: questions about misfits, unseen effects, parameters, drive gains."""
    listed = []
    for question in belief.questions:
        if question.seen:
            likely = [answer for answer in question.answers if answer.probability > EXCLUDED]
            words = " or ".join(map(_label, likely))
            listed.append(Item(words, entropy(question.probabilities), not question.settled))
    unseen = sum(entropy(question.probabilities) for question in belief.questions if not question.seen)
    listed.append(Item(UNSEEN, unseen, hidden(belief) > 1.0 - CREDIBLE, Subject.UNSEEN))
    listed.append(Item(PARAMETERS, parameter_entropy(belief), open_torque(belief) > 1.0, Subject.PARAMETERS))
    return [*listed, Item(GAINS, gain_entropy(belief), bool(untested(belief)), Subject.GAINS)]


def compared(belief: Belief) -> Compared:
    """The questions about a misfit, with the separations of their answers so far."""
    questions = []
    for question in belief.questions:
        if question.seen:
            stances = [belief.stance(question, answer) for answer in question.answers]
            questions.append((question, stances, separations(stances, belief.gram)))
    return questions


def expected_entropies(belief: Belief, compared: Compared, seen: np.ndarray) -> np.ndarray:
    """Expected entropy of each item after a run, shape (i,) [nat].

    An item that the run decides has no entropy: what is certain enough is no reason for another run.

    Args:
        belief: Belief after the runs so far.
        compared: Questions with the separations of their answers so far.
        seen: Products of all columns in the run, shape (c, c).
    """
    entropies = []
    for question, stances, before in compared:
        further = np.maximum(separations(stances, belief.gram + seen) - before, 0.0)
        # A run must show by itself whether there is an effect; strained priors count only once.
        nothing = [not answer.effect for answer in question.answers]
        alone = separations(stances, seen, strain=question.finding_places.size > 0)[:, nothing]
        was_found = question.finding_places.size > 0
        further[:, nothing] = alone if was_found else np.maximum(further[:, nothing], alone)
        entropies.append(expected_entropy(question.probabilities, further, question.decisive))
    unseen = [_unseen_left(belief, question, seen) for question in belief.questions if not question.seen]
    shown = 1.0 - float(np.prod([1.0 - there for there in unseen])) <= 1.0 - CREDIBLE
    entropies.append(0.0 if shown else sum(entropy(np.array([there, 1.0 - there])) for there in unseen))
    entropies.append(parameter_entropy(belief, seen) if open_torque(belief, seen) > 1.0 else 0.0)
    return np.array([*entropies, gain_entropy(belief, seen) if untested(belief, seen) else 0.0])


def information(belief: Belief, run: RunColumns) -> np.ndarray:
    """Weighted products of all columns in a run, shape (c, c); unknowns of a new body are eliminated."""
    names = belief.search.prediction.rows.names
    gram, count = run.products(names, belief.weight)
    known = run.known(names)
    if not len(known):
        return gram
    mixed, fitted = gram[:count, count:], gram[count:, count:] + np.diag(known)
    return np.asarray(gram[:count, :count] - mixed @ solve(factored(fitted), mixed.T))


def entropy(probability: np.ndarray) -> float:
    """Entropy of answers with probabilities (m,) [nat]."""
    return float(entr(probability).sum())


def expected_entropy(
    probability: np.ndarray, separation: np.ndarray, decisive: np.ndarray | None = None
) -> float:
    """Entropy of answers after a run, averaged over its possible outcomes [nat].

    If answer i is true and j its rival, the run multiplies the odds of i against j by a factor whose
    logarithm is normal with mean T/2 and variance T, where T is their separation.

    Args:
        probability: Probabilities before the run, shape (m,).
        separation: Separation of each true answer (row) from each rival (column), shape (m, m).
        decisive: Probability from which on each answer decides the question, which then has no entropy,
            shape (m,); no answer decides by default.
    """
    decisive = np.full(len(probability), np.inf) if decisive is None else decisive
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
        undecided = ~np.any(after >= decisive, axis=1)
        total += float(probability[true]) * float((undecided * entr(after).sum(axis=1)).mean())
    return min(total, entropy(probability))  # the expectation never exceeds it, but a sample mean may


def parameter_entropy(belief: Belief, seen: np.ndarray | None = None) -> float:
    """Entropy of the torque that parameters and findings leave open [nat].

    It is half the sum of log(1 + s^2) over independent parts of the torque, where s is the standard deviation
    of a part over the resolution. Far below the resolution, better knowledge counts for nothing. No part is
    taken as less certain than the usual torque itself.

    Args:
        belief: Belief after the runs so far.
        seen: Products of all columns in a further run, shape (c, c).
    """
    known, reach = _known(belief, seen), _parameter_reach(belief)
    return 0.5 * (_log_determinant(known + reach) - _log_determinant(known))


def open_torque(belief: Belief, seen: np.ndarray | None = None) -> float:
    """RMS uncertainty of the parameters' torque over the resolution [-]; `seen` as in `parameter_entropy`."""
    inverse = solve(factored(_known(belief, seen)), _parameter_reach(belief))
    return float(np.sqrt(max(np.trace(inverse), 0.0) / len(belief.weight)))


def hidden(belief: Belief) -> float:
    """Probability that an effect of relevant size is there that no run so far could show."""
    unseen = [question.answers for question in belief.questions if not question.seen]
    absent = [answer.probability for answers in unseen for answer in answers if not answer.effect]
    return 1.0 - float(np.prod(absent))


def remaining(belief: Belief, question: Question) -> Iterator[str]:
    """Sentences about a question that no run on offer decides: its answers, why, and what would decide."""
    joints = belief.search.problem.model.robot.joints
    likely = [answer for answer in question.answers if answer.probability > EXCLUDED]
    names = [f"{_name(answer, joints)} ({percent(answer.probability)})" for answer in likely]
    yield f"{joined(names, 'or')}."
    share = _coincidence(belief, question)
    if share > 0.0:
        first, second = (_name(answer, joints) for answer in question.answers[:2])
        yield (
            f"No motion can decide: in all runs so far and on offer, {second} and the other unknowns "
            f"reproduce {100 * share:.4g} % of the torque of {first}."
        )
    if cures := _cures(likely):
        yield f"What would decide: {joined(cures, 'or')}."


def unseen_words(belief: Belief) -> str:
    """Text about effects that may be there although no run so far or on offer would show them."""
    joints = belief.search.problem.model.robot.joints
    unseen = [question.answers for question in belief.questions if not question.seen]
    effects = [answer for answers in unseen for answer in answers if answer.effect]
    effects = sorted(effects, key=lambda answer: -answer.probability)[:NAMED_UNSEEN]
    names = [lower(f"{_name(answer, joints)} ({percent(answer.probability)})") for answer in effects]
    text = f"No run so far or on offer would show {joined(names, 'or')}."
    cures = _cures(effects)
    return f"{text} What would show them: {joined(cures, 'or')}." if cures else text


def _unseen_left(belief: Belief, question: Question, seen: np.ndarray) -> float:
    """Probability that an unseen effect is there after a run that does not show it either."""
    before, there = material(belief, question), question.answers[0].probability
    return there * min(material(belief, question, seen) / max(before, 1e-12), 1.0)


def _known(belief: Belief, seen: np.ndarray | None) -> np.ndarray:
    count = belief.unknowns
    matrix = belief.posterior(np.arange(count))[0] + LINEAR**2 * _parameter_reach(belief)
    return matrix if seen is None else matrix + seen[:count, :count]


def _parameter_reach(belief: Belief) -> np.ndarray:
    """`Belief.reach` of the unknowns without nuisances."""
    names, count = belief.search.prediction.rows.names, belief.unknowns
    relevant = np.array([not name.startswith(NUISANCES) for name in names])
    return np.asarray(belief.reach[:count, :count] * np.outer(relevant, relevant))


def _log_determinant(matrix: np.ndarray) -> float:
    factor = factored(matrix)
    return 2.0 * float(np.sum(np.log(np.diag(factor.triangle))) - np.sum(np.log(factor.scale)))


def _coincidence(belief: Belief, question: Question) -> float:
    """Share of the first answer's torque in all runs that the second one reproduces [-]."""
    first, second = question.answers[:2]
    if not len(first.places):
        return 0.0
    values = belief.posterior(belief.held_by(question, first))[1][-len(first.places) :]
    held, reach = belief.held_by(question, second), belief.reach
    total = float(values @ reach[np.ix_(first.places, first.places)] @ values)
    mixed = reach[np.ix_(held, first.places)] @ values
    reproduced = float(mixed @ solve(factored(reach[np.ix_(held, held)]), mixed))
    return reproduced / total if total > 0.0 else 0.0


def _cures(answers: Sequence[Believed]) -> list[str]:
    """What would decide whether the effects are there, each once."""
    words = [kind_of(answer.effect).settled_by for answer in answers if answer.effect]
    return list(dict.fromkeys(filter(None, words)))


def _label(answer: Believed) -> str:
    effect = answer.effect.replace("_", " ") or "nothing"
    return f"{effect} ({', '.join(str(joint + 1) for joint in answer.joints)})" if answer.joints else effect


def _name(answer: Believed, joints: tuple[str, ...]) -> str:
    return named(answer.effect, answer.joints, joints) if answer.effect else "nothing"
