"""Questions that a search leaves: whether a finding is that, and whether something is there unseen."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import erfc, expit

from ...positive_definite import solve
from ..blocks.block_likelihood import log_probability
from ..blocks.prediction import CERTAIN, LINEAR, Prediction, factored
from ..findings.finding import Diagnosis
from ..questions.block_answer import CERTAIN_ODDS, CREDIBLE, prior_std
from ..questions.candidate_fit import FORMULA, STRANGE
from ..questions.comparison import competing
from ..results.evidence import explained, places_of
from ..results.remainder import rms
from ..search.search import SearchResult
from ..search.selected import EXCLUDED, NAMED, contradicted, log_prior
from .belief import Belief, Believed, Question
from .run_columns import RunColumns, products
from .suspects import NEGLIGIBLE, Suspects, place_of, unseen_probability


def belief_of(
    search: SearchResult, suspects: Suspects, runs: Sequence[RunColumns], nameless: np.ndarray | None = None
) -> Belief:
    """The belief after a search, and what runs on offer could show.

    Args:
        search: Search of the diagnosis.
        suspects: What may be there beside what was found.
        runs: On offer.
        nameless: Squared torque of each joint that is left without a name, shape (n,) [(N m)^2]; else none.
    """
    prediction = search.prediction
    joints, fitted = prediction.joints, prediction.weighting.weight[prediction.blocks.number]
    columns = np.concatenate(
        [prediction.rows.columns, *(one.columns.everywhere(joints) for one in suspects.every)], axis=2
    )
    weight = fitted * prediction.rows.weight
    std = [prediction.rows.std, *(prior_std(one.candidate, one.columns) for one in suspects.rivals)]
    # no larger in any run than it may be there: the run that shows it best limits it
    std += [
        np.min([one.columns.std, *(run.suspects[place] for run in runs)], axis=0)
        for place, one in enumerate(suspects.left, len(suspects.rivals))
    ]
    belief = Belief(
        search,
        suspects.every,
        products(columns, weight),
        np.einsum("rnc,rn->c", columns, weight * prediction.rows.difference),
        np.maximum(np.concatenate(std), CERTAIN) ** -2.0,
        np.concatenate([prediction.rows.mean, *(one.columns.mean for one in suspects.every)]),
        prediction.weighting.independent / prediction.weighting.variance,
        _reaches(search, columns, weight > 0.0, runs),
    )
    nameless = np.zeros(joints) if nameless is None else nameless
    suspected = list(_about_suspected(belief, len(suspects.rivals)))
    asked = {int(place) for question in suspected for one in question.answers for place in one.places}
    unseen = _about_unseen(belief, len(suspects.rivals), asked)
    questions = (*_about_findings(belief, suspects, nameless), *suspected, *unseen)
    return replace(belief, questions=questions)


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


def confirmed(search: SearchResult, place: int) -> bool:
    """Whether some run is more probable with a finding of the others by 19 to 1, and the rest not less so.

    Blocks of one motion share what it does not show, so that they are no proof of each other.
    """
    prediction = search.prediction
    if len(prediction.rows.runs) < 2:
        return False
    without = np.setdiff1d(np.arange(len(prediction.rows.names)), places_of(search, place))
    starts = np.array([piece.start for piece in prediction.blocks.rows])
    gains = [
        _run_gain(prediction, (starts >= rows.start) & (starts < rows.stop), without)
        for rows in prediction.rows.runs
    ]
    return max(gains) > CERTAIN_ODDS and sum(gains) - max(gains) > -CERTAIN_ODDS


def refused(search: SearchResult, place: int) -> bool:
    """Whether beside all that was found a coefficient is where physics excludes it.

    When it was asked for, it was not: what it left counted as noise, beside which the prior held it.
    """
    columns = search.selected[place].answer.columns
    values, known = search.prediction.values[places_of(search, place)], columns.mean != 0.0
    return bool(np.any(np.abs(values - columns.mean)[known] > STRANGE * columns.std[known]))


def nameless_torque(diagnosis: Diagnosis, search: SearchResult) -> np.ndarray:
    """Squared torque of each joint that is left and depends on something, shape (n,) [(N m)^2].

    Beyond noise and the errors of the formulas found. What depends on nothing that was recorded is taken for
    noise of drives that move.
    """
    assert diagnosis.evidence is not None
    weight, noise = search.prediction.rows.weight, np.asarray(diagnosis.evidence.noise)
    formulas = np.sum((FORMULA * _finding_torques(search)) ** 2, axis=0)
    left = np.maximum(rms(search.prediction.residual, weight) ** 2 - noise**2 - formulas, 0.0)
    dependent = [one.joint for one in diagnosis.remainders if one.predictable]
    return np.where(np.isin(np.arange(len(left)), dependent), left, 0.0)


def nameless_odds(search: SearchResult, place: int, nameless: np.ndarray) -> float:
    """What is left without a name (n,) [(N m)^2], over what a finding explains: it may be part of that.

    Of their squared torques, on the joint where the finding stands out most. Above one, most of the misfit is
    not explained.
    """
    torque = _finding_torques(search)[place]
    own = torque > 0.0
    return float(np.min(nameless[own] / torque[own] ** 2)) if np.any(own) else 0.0


def _reaches(
    search: SearchResult, columns: np.ndarray, counts: np.ndarray, runs: Sequence[RunColumns]
) -> np.ndarray:
    """As in `Belief`: the resolution is a share of the largest usual torque of each joint."""
    names = search.prediction.rows.names
    torque = np.concatenate([run.thinned(run.torque) for run in search.problem.runs])
    usual = np.sqrt(np.max([np.mean(torque**2, axis=0), *(run.power for run in runs)], axis=0))
    share = (LINEAR * np.maximum(usual, 1e-9)) ** -2.0
    found = [products(columns, counts * share / max(len(columns), 1))]
    for run in runs:
        every, count = run.products(names, share / max(run.rows, 1))
        found.append(every[:count, :count])
    return np.array(found)


def _about_findings(belief: Belief, suspects: Suspects, nameless: np.ndarray) -> Iterator[Question]:
    """A question for each finding: whether it is that, what else it may be, or nothing.

    The blocks cannot say more against another answer than the torque, to within what formulas are wrong by;
    nor more against nothing than a name needs, before another run has confirmed it, where its formula is
    refused, or where more is left that has no name than it explains.
    """
    search = belief.search
    columns = dict(zip(map(place_of, suspects.rivals), belief.places, strict=False))
    for place, one in enumerate(search.selected):
        if one.once:
            continue  # it is in no other run
        own, here = places_of(search, place), place_of(one.answer)
        weights = {place_of(other): probability for other, probability in one.elsewhere}
        for other, odds in suspects.against[place].items():
            least = one.certainty * float(np.exp(-max(odds, 0.0)))
            weights[other] = max(weights.get(other, 0.0), least)
        weights = {here: one.certainty} | {other: p for other, p in weights.items() if other != here}
        nothing = float(expit(-one.odds))
        if (
            refused(search, place)
            or nameless_odds(search, place, nameless) > 1.0
            or not confirmed(search, place)
        ):
            nothing = max(nothing, (1.0 / NAMED - 1.0) * sum(weights.values()))
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


def _about_suspected(belief: Belief, first: int) -> Iterator[Question]:
    """Which of some suspects is there, or none: something speaks for each, but not enough to find it.

    Such as values that are strained beyond their tolerances. Those that one joint sees are asked about
    together, where one that matters is there with more than 5 %.
    """
    weights = {place: _suspicion(belief, place) for place in range(first, len(belief.suspects))}
    left = [place for place, weight in weights.items() if weight > 0.0]
    while left:
        head = max(left, key=lambda place: weights[place])
        own = [k for k in left if k == head or competing(belief.suspects[k], belief.suspects[head])]
        left = [place for place in left if place not in own]
        odds = np.array([*(weights[place] for place in own), 1.0])
        if odds[:-1].sum() < (1.0 - CREDIBLE) / CREDIBLE:
            continue
        answers = [Believed(*place_of(belief.suspects[k]), 0.0, belief.places[k]) for k in own]
        answers.append(Believed("", (), 0.0, np.zeros(0, int)))
        yield Question(_shared(answers, odds), True, np.zeros(0, int))


def _suspicion(belief: Belief, place: int) -> float:
    """Odds that a suspect is there and matters, against nothing; zero where nothing speaks for it."""
    one = belief.suspects[place]
    if one.odds <= 0.0 or contradicted(one):
        return 0.0
    there = Believed(*place_of(one), 1.0, belief.places[place])
    matters = material(belief, Question((there,), False, np.zeros(0, int)))
    return matters * float(np.exp(min(one.odds + log_prior(one, belief.search.total), 700.0)))


def _about_unseen(belief: Belief, first: int, asked: set[int]) -> Iterator[Question]:
    """Whether an effect that was not found is there all the same, and large enough to matter."""
    none = np.zeros(0, int)
    for number, (one, places) in enumerate(zip(belief.suspects, belief.places, strict=True)):
        if number < first or int(places[0]) in asked:
            continue
        there = Believed(one.candidate.effect, one.candidate.joints, 1.0, places)
        question = Question((there,), False, none)
        probability = unseen_probability(one, belief.search.total) * material(belief, question)
        if probability >= NEGLIGIBLE:
            answers = (there._replace(probability=probability), Believed("", (), 1.0 - probability, none))
            yield question._replace(answers=answers)


def _run_gain(prediction: Prediction, left_out: np.ndarray, without: np.ndarray) -> float:
    """Logarithm of how much more probable a run's blocks are with a finding, fitted to the other runs."""
    every = np.arange(len(prediction.rows.names))
    gram, right = prediction.sums.normal_equations(prediction.weighting.weight, len(every))
    matrix = gram[~left_out].sum(axis=0) + np.diag(prediction.precision)
    right = right[~left_out].sum(axis=0) + prediction.precision * prediction.rows.mean
    share, counts = prediction.weighting.independent, prediction.sums.counts[left_out]
    found = []
    for held in (every, without):
        values = np.zeros(len(every))
        values[held] = solve(factored(matrix[np.ix_(held, held)]), right[held])
        errors = prediction.sums.errors(np.tile(values, (len(left_out), 1)))[left_out]
        found.append(float(log_probability(share * errors, share * counts).sum()))
    return found[0] - found[1]


def _finding_torques(search: SearchResult) -> np.ndarray:
    """Root mean square torque of each finding, shape (f, n) [N m]."""
    prediction = search.prediction
    torques = explained(search, prediction.rows, prediction.values)
    return np.array([rms(one, prediction.rows.weight) for one in torques]).reshape(-1, prediction.joints)
