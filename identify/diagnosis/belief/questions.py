"""Questions that a search leaves open: which effect a finding is, and whether unseen effects are there."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import erfc, expit

from ...positive_definite import solve
from ..blocks.block_likelihood import log_probability
from ..blocks.prediction import CERTAIN, LINEAR, Prediction, factored
from ..findings.diagnosis import Diagnosis
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
    """The belief after a search, given the runs on offer.

    Args:
        search: Search of the diagnosis.
        suspects: Effects besides the findings that may be there.
        runs: Columns of the runs on offer.
        nameless: Squared torque of each joint that no effect explains, shape (n,) [(N m)^2]; zero by default.
    """
    prediction = search.prediction
    joints, fitted = prediction.joints, prediction.weighting.weight[prediction.blocks.number]
    columns = np.concatenate(
        [prediction.rows.columns, *(suspect.columns.everywhere(joints) for suspect in suspects.every)], axis=2
    )
    weight = fitted * prediction.rows.weight
    std = [prediction.rows.std, *(prior_std(rival.candidate, rival.columns) for rival in suspects.rivals)]
    # The run that shows an unseen effect best limits its size.
    std += [
        np.min([unseen.columns.std, *(run.suspects[place] for run in runs)], axis=0)
        for place, unseen in enumerate(suspects.unseen, len(suspects.rivals))
    ]
    belief = Belief(
        search,
        suspects.every,
        products(columns, weight),
        np.einsum("rnc,rn->c", columns, weight * prediction.rows.difference),
        np.maximum(np.concatenate(std), CERTAIN) ** -2.0,
        np.concatenate([prediction.rows.mean, *(suspect.columns.mean for suspect in suspects.every)]),
        prediction.weighting.independent / prediction.weighting.variance,
        _reaches(search, columns, weight > 0.0, runs),
    )
    nameless = np.zeros(joints) if nameless is None else nameless
    suspected = list(_about_suspected(belief, len(suspects.rivals)))
    answers = [answer for question in suspected for answer in question.answers]
    covered = {int(place) for answer in answers for place in answer.places}
    unseen = _about_unseen(belief, len(suspects.rivals), covered)
    questions = (*_about_findings(belief, suspects, nameless), *suspected, *unseen)
    return replace(belief, questions=questions)


def material(belief: Belief, question: Question, more: np.ndarray | None = None) -> float:
    """Probability that an unseen effect, if it is there, changes the torque of some run by the resolution.

    Torque that the model's unknowns reproduce, within what the runs so far allow, does not count; nor does
    torque that a further run would have shown.

    Args:
        belief: Belief after the runs so far.
        question: Question whose first answer is the effect.
        more: Products of all columns in a further run that does not show the effect, shape (c, c).
    """
    variations = belief.variations(question, question.answers[0], more)
    if more is not None:
        variations[:, 0] = 0.0  # the run shows no effect, so none is expected
    used = np.flatnonzero(np.any(variations, axis=1))
    reaches = belief.reaches[:, used[:, None], used]
    square = float(np.max(np.sum(variations[used] * (reaches @ variations[used]), axis=(1, 2))))
    return float(erfc(1.0 / np.sqrt(2.0 * max(square, 1e-12))))


def confirmed(search: SearchResult, place: int) -> bool:
    """Whether a finding, fitted to the other runs, makes one run 19 times as probable and the rest not less.

    Blocks of one motion share its blind spots, so they cannot confirm each other.
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


def excluded_by_physics(search: SearchResult, place: int) -> bool:
    """Whether physics excludes a coefficient of a finding, as fitted with all findings.

    When the finding was chosen, the residual was larger and counted as noise, so the prior held the
    coefficient within its limit.
    """
    columns = search.selected[place].answer.columns
    values, sized = search.prediction.values[places_of(search, place)], columns.mean != 0.0
    return bool(np.any(np.abs(values - columns.mean)[sized] > STRANGE * columns.std[sized]))


def nameless_torque(diagnosis: Diagnosis, search: SearchResult) -> np.ndarray:
    """Squared residual torque of each joint that depends on a recorded quantity, shape (n,) [(N m)^2].

    Noise and the formula errors of findings are subtracted. A residual that depends on no recorded quantity
    counts as noise of moving drives.
    """
    assert diagnosis.evidence is not None
    weight, noise = search.prediction.rows.weight, np.asarray(diagnosis.evidence.noise)
    formulas = np.sum((FORMULA * _finding_torques(search)) ** 2, axis=0)
    square = np.maximum(rms(search.prediction.residual, weight) ** 2 - noise**2 - formulas, 0.0)
    dependent = [remainder.joint for remainder in diagnosis.remainders if remainder.predictable]
    return np.where(np.isin(np.arange(len(square)), dependent), square, 0.0)


def nameless_odds(search: SearchResult, place: int, nameless: np.ndarray) -> float:
    """Ratio of the unexplained squared torque (n,) [(N m)^2] to that of a finding, on its clearest joint [-].

    Above 1, most of the misfit is unexplained, and the finding may be part of an unnamed effect.
    """
    torque = _finding_torques(search)[place]
    acting = torque > 0.0
    return float(np.min(nameless[acting] / torque[acting] ** 2)) if np.any(acting) else 0.0


def _reaches(
    search: SearchResult, columns: np.ndarray, counts: np.ndarray, runs: Sequence[RunColumns]
) -> np.ndarray:
    """`Belief.reaches`, with a resolution that is a share of the largest usual torque of each joint."""
    names = search.prediction.rows.names
    torque = np.concatenate([run.thinned(run.torque) for run in search.problem.runs])
    usual = np.sqrt(np.max([np.mean(torque**2, axis=0), *(run.power for run in runs)], axis=0))
    share = (LINEAR * np.maximum(usual, 1e-9)) ** -2.0
    reaches = [products(columns, counts * share / max(len(columns), 1))]
    for run in runs:
        gram, count = run.products(names, share / max(run.rows, 1))
        reaches.append(gram[:count, :count])
    return np.array(reaches)


def _about_findings(belief: Belief, suspects: Suspects, nameless: np.ndarray) -> Iterator[Question]:
    """A question for each finding: whether it is this effect, one of its rivals, or no effect.

    Two limits keep the evidence of blocks from being overrated:

    * Against a rival, it counts no more than the difference in torque, given the error of formulas.
    * Against "no effect", it counts no more than naming requires, unless another run confirms the finding,
      physics allows its coefficients, and it explains more than what remains unexplained.
    """
    search = belief.search
    columns = dict(zip(map(place_of, suspects.rivals), belief.places, strict=False))
    for place, finding in enumerate(search.selected):
        if finding.once:
            continue  # no other run can show it
        places, here = places_of(search, place), place_of(finding.answer)
        weights = {place_of(other): probability for other, probability in finding.elsewhere}
        for other, odds in suspects.against[place].items():
            least = finding.certainty * float(np.exp(-max(odds, 0.0)))
            weights[other] = max(weights.get(other, 0.0), least)
        weights = {here: finding.certainty} | {other: p for other, p in weights.items() if other != here}
        nothing = float(expit(-finding.odds))
        if (
            excluded_by_physics(search, place)
            or nameless_odds(search, place, nameless) > 1.0
            or not confirmed(search, place)
        ):
            nothing = max(nothing, (1.0 / NAMED - 1.0) * sum(weights.values()))
        answers = [Believed(*other, 0.0, places if other == here else columns[other]) for other in weights]
        answers.append(Believed("", (), 0.0, np.zeros(0, int)))
        yield Question(_shared(answers, np.array([*weights.values(), nothing])), True, places)


def _shared(answers: Sequence[Believed], weights: np.ndarray) -> tuple[Believed, ...]:
    """Answers that are not excluded, most probable first; the first and the last ("no effect") stay."""
    included = weights > EXCLUDED * weights.sum()
    included[[0, -1]] = True
    shares = np.where(included, weights, 0.0) / weights[included].sum()
    pairs = zip(answers, shares, included, strict=True)
    remaining = [answer._replace(probability=float(share)) for answer, share, keep in pairs if keep]
    return tuple(sorted(remaining, key=lambda answer: -answer.probability))


def _about_suspected(belief: Belief, first: int) -> Iterator[Question]:
    """Questions about suspects with some evidence, but not enough to be findings: which of them is there?

    Such evidence may be values strained beyond their tolerances. Suspects on the same joint share a question,
    which is asked if a relevant one is there with a probability above 5 %.
    """
    weights = {place: _suspicion(belief, place) for place in range(first, len(belief.suspects))}
    waiting = [place for place, weight in weights.items() if weight > 0.0]
    while waiting:
        head = max(waiting, key=lambda place: weights[place])
        group = [k for k in waiting if k == head or competing(belief.suspects[k], belief.suspects[head])]
        waiting = [place for place in waiting if place not in group]
        odds = np.array([*(weights[place] for place in group), 1.0])
        if odds[:-1].sum() < (1.0 - CREDIBLE) / CREDIBLE:
            continue
        answers = [Believed(*place_of(belief.suspects[k]), 0.0, belief.places[k]) for k in group]
        answers.append(Believed("", (), 0.0, np.zeros(0, int)))
        yield Question(_shared(answers, odds), True, np.zeros(0, int))


def _suspicion(belief: Belief, place: int) -> float:
    """Odds that a suspect is there and relevant, against "no effect"; zero without evidence for it."""
    suspect = belief.suspects[place]
    if suspect.odds <= 0.0 or contradicted(suspect):
        return 0.0
    present = Believed(*place_of(suspect), 1.0, belief.places[place])
    relevance = material(belief, Question((present,), False, np.zeros(0, int)))
    return relevance * float(np.exp(min(suspect.odds + log_prior(suspect, belief.search.total), 700.0)))


def _about_unseen(belief: Belief, first: int, covered: set[int]) -> Iterator[Question]:
    """Questions whether effects of relevant size are there although they were not found."""
    none = np.zeros(0, int)
    for number, (suspect, places) in enumerate(zip(belief.suspects, belief.places, strict=True)):
        if number < first or int(places[0]) in covered:
            continue
        present = Believed(suspect.candidate.effect, suspect.candidate.joints, 1.0, places)
        question = Question((present,), False, none)
        probability = unseen_probability(suspect, belief.search.total) * material(belief, question)
        if probability >= NEGLIGIBLE:
            answers = (present._replace(probability=probability), Believed("", (), 1.0 - probability, none))
            yield question._replace(answers=answers)


def _run_gain(prediction: Prediction, left_out: np.ndarray, without: np.ndarray) -> float:
    """Gain in log probability of a run's blocks with a finding, fitted to the other runs."""
    all_unknowns = np.arange(len(prediction.rows.names))
    gram, right = prediction.sums.normal_equations(prediction.weighting.weight, len(all_unknowns))
    matrix = gram[~left_out].sum(axis=0) + np.diag(prediction.precision)
    right = right[~left_out].sum(axis=0) + prediction.precision * prediction.rows.mean
    share, counts = prediction.weighting.independent, prediction.sums.counts[left_out]
    log_probabilities = []
    for held in (all_unknowns, without):
        values = np.zeros(len(all_unknowns))
        values[held] = solve(factored(matrix[np.ix_(held, held)]), right[held])
        errors = prediction.sums.errors(np.tile(values, (len(left_out), 1)))[left_out]
        log_probabilities.append(float(log_probability(share * errors, share * counts).sum()))
    return log_probabilities[0] - log_probabilities[1]


def _finding_torques(search: SearchResult) -> np.ndarray:
    """RMS torque of each finding on each joint, shape (f, n) [N m]."""
    prediction = search.prediction
    torques = explained(search, prediction.rows, prediction.values)
    return np.array([rms(torque, prediction.rows.weight) for torque in torques]).reshape(
        -1, prediction.joints
    )
