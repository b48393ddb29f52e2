"""Questions that a search leaves: whether a finding is that, and whether something is there unseen."""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.special import erfc, expit

from exidyn.identify.diagnosis.results.evidence import places_of
from exidyn.identify.diagnosis.search.selected import EXCLUDED, NAMED

from .belief import Belief, Believed, Question
from .confirmation import confirmed
from .refused import nameless_odds, refused
from .suspects import NEGLIGIBLE, Suspects, place_of, unseen_probability


def asked_of(belief: Belief, suspects: Suspects, left: np.ndarray) -> Iterator[Question]:
    """A question for each finding: whether it is that, what else it may be, or nothing.

    The blocks cannot say more against another answer than the torque, to within what formulas are wrong by;
    nor more against nothing than a name needs, before another run has confirmed it, where its formula is
    refused, or where more is left that has no name than it explains.
    """
    columns = dict(zip(map(place_of, suspects.rivals), belief.places, strict=False))
    for place, one in enumerate(belief.search.selected):
        if one.once:
            continue  # it is in no other run
        own, here = places_of(belief.search, place), place_of(one.answer)
        weights = {place_of(other): probability for other, probability in one.elsewhere}
        for other, odds in suspects.against[place].items():
            least = one.certainty * float(np.exp(-max(odds, 0.0)))
            weights[other] = max(weights.get(other, 0.0), least)
        weights = {here: one.certainty} | {other: p for other, p in weights.items() if other != here}
        some = sum(weights.values())
        nothing, search = float(expit(-one.odds)), belief.search
        if refused(search, place) or nameless_odds(search, place, left) > 1.0 or not confirmed(search, place):
            nothing = max(nothing, (1.0 / NAMED - 1.0) * some)
        answers = [Believed(*other, 0.0, own if other == here else columns[other]) for other in weights]
        answers.append(Believed("", (), 0.0, np.zeros(0, int)))
        yield Question(_shared(answers, np.array([*weights.values(), nothing])), True, own)


def _shared(answers: Sequence[Believed], weights: np.ndarray) -> tuple[Believed, ...]:
    """Answers that are not excluded, the most probable first; the first and that nothing is there stay."""
    kept = weights > EXCLUDED * weights.sum()
    kept[[0, -1]] = True
    shares = np.where(kept, weights, 0.0) / weights[kept].sum()
    pairs = zip(answers, shares, kept, strict=True)
    found = [answer._replace(probability=float(share)) for answer, share, stays in pairs if stays]
    return tuple(sorted(found, key=lambda answer: -answer.probability))


def unseen_of(belief: Belief, first: int) -> Iterator[Question]:
    """Whether an effect that was not found is there all the same, and large enough to matter."""
    none = np.zeros(0, int)
    for place, one in enumerate(belief.suspects):
        if place < first:
            continue
        there = Believed(one.candidate.effect, one.candidate.joints, 1.0, belief.places[place])
        question = Question((there,), False, none)
        probability = unseen_probability(one, belief.search.total) * material(belief, question)
        if probability < NEGLIGIBLE:
            continue
        answers = (there._replace(probability=probability), Believed("", (), 1.0 - probability, none))
        yield question._replace(answers=answers)


def material(belief: Belief, question: Question, more: np.ndarray | None = None) -> float:
    """Probability that an unseen effect, if it is there, changes the torque of some run by the resolution.

    What the model's own unknowns make up for, as the runs so far bind them, changes nothing; nor does what a
    further run, with these products (c, c), would have shown.
    """
    ways = belief.ways(question, question.answers[0], more)
    if more is not None:
        ways[:, 0] = 0.0  # where the run shows nothing
    used = np.flatnonzero(np.any(ways, axis=1))
    each = belief.reaches[:, used[:, None], used]
    square = float(np.max(np.sum(ways[used] * (each @ ways[used]), axis=(1, 2))))
    return float(erfc(1.0 / np.sqrt(2.0 * max(square, 1e-12))))
