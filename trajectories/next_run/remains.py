"""Remains: what no motion decides, why, and what would."""

from collections.abc import Iterator

import numpy as np

from exidyn.identify.diagnosis.blocks.prediction import factored
from exidyn.identify.diagnosis.candidates import kind_of
from exidyn.identify.diagnosis.search.selected import EXCLUDED
from exidyn.identify.diagnosis.words.naming import joined, lower, named
from exidyn.identify.positive_definite import solve

from .belief.belief import Belief, Believed, Question


def coincidence(belief: Belief, question: Question) -> float:
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


def remaining(belief: Belief, question: Question) -> Iterator[str]:
    """Sentences about a question that no run on offer decides.

    What remains, why no motion settles it, and what would.
    """
    joints = belief.search.problem.model.robot.joints
    open_ones = [one for one in question.answers if one.probability > EXCLUDED]
    names = [f"{_named(one, joints)} ({100 * one.probability:.2g} %)" for one in open_ones]
    yield f"{joined(names, 'or')}."
    share = coincidence(belief, question)
    if share > 0.0:
        others = _named(question.answers[1], joints)
        yield (
            f"No motion settles it: in all runs so far and on offer, {others} and the other unknowns make up "
            f"for {100 * share:.4g} % of the torque of {_named(question.answers[0], joints)}."
        )
    would = [kind_of(one.effect).settled_by for one in open_ones if one.effect]
    if cures := list(dict.fromkeys(words for words in would if words)):
        yield f"What would: {joined(cures, 'or')}."


def _named(one: Believed, joints: tuple[str, ...]) -> str:
    return named(one.effect, one.joints, joints) if one.effect else "nothing"


MOST = 5
"""Effects that are named, of those that no run shows."""


def unseen_words(belief: Belief) -> str:
    """What may be there without any run on offer showing it."""
    joints = belief.search.problem.model.robot.joints
    there = [
        one for question in belief.questions if not question.seen for one in question.answers if one.effect
    ]
    there.sort(key=lambda one: -one.probability)
    names = [f"{_named(one, joints)} ({100 * one.probability:.2g} %)" for one in there[:MOST]]
    would = [words for one in there[:MOST] if (words := kind_of(one.effect).settled_by)]
    text = f"No run so far or on offer would show {joined([lower(name) for name in names], 'or')}."
    return f"{text} What would: {joined(list(dict.fromkeys(would)), 'or')}." if would else text
