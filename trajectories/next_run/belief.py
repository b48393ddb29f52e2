"""Belief: what a diagnosis leaves open, and with which probabilities and precisions."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.special import erfc, expit

from exidyn.identify.diagnosis.blocks.prediction import CERTAIN, factored, solve
from exidyn.identify.diagnosis.questions.block_answer import Answer, prior_std
from exidyn.identify.diagnosis.questions.comparison import LINEAR
from exidyn.identify.diagnosis.results.evidence import places_of
from exidyn.identify.diagnosis.search.search import SearchResult
from exidyn.identify.diagnosis.search.selected import CERTAIN_ODDS, EXCLUDED, NAMED, log_prior

from .columns import RunColumns
from .confirmation import confirmed
from .refused import nameless_odds, refused
from .rivals import rivals
from .separations import Stance

NUISANCES = ("reversal", "clock")
"""Beginnings of the names of unknowns that are nobody's question."""

NEGLIGIBLE = EXCLUDED / 100.0
"""Probability below which an effect that nothing suggests is not asked about; a hundred of them are still
excluded together."""


Place = tuple[str, tuple[int, ...]]
"""An effect and its joints."""


class Believed(NamedTuple):
    """One answer to a question.

    Attributes:
        effect: Name in the vocabulary; empty for nothing.
        joints: Where, from 0.
        probability: [-].
        places: Of its coefficients among all columns, (p,).
    """

    effect: str
    joints: tuple[int, ...]
    probability: float
    places: np.ndarray


class Question(NamedTuple):
    """What may explain one misfit, or whether one effect is there.

    Attributes:
        answers: The most probable first; their probabilities add to one.
        seen: Whether a misfit asks it; else nothing does but that no run so far could show the effect.
        own: Unknowns that belong to the finding in question, not there for other answers, (p,).
    """

    answers: tuple[Believed, ...]
    seen: bool
    own: np.ndarray

    @property
    def probabilities(self) -> np.ndarray:
        """Of the answers, shape (m,)."""
        return np.array([one.probability for one in self.answers])


@dataclass(frozen=True, eq=False)
class Belief:
    """The posterior of a diagnosis: unknowns, then coefficients of all suspects, c columns together.

    Attributes:
        search: Of the diagnosis.
        suspects: What is not in the model and may be there.
        gram: Products of all columns over the runs so far, weighted as the diagnosis did, shape (c, c).
        right: The same with what they explain, shape (c,).
        precision: Of priors, shape (c,); zero where nothing is known.
        mean: Of priors, shape (c,).
        weight: Of a row of each joint of a further run, shape (n,) [1 / (N m)^2].
        reaches: Products of all columns over the runs so far, and over each on offer, in units of the
            resolution, a mean over rows, shape (k, c, c): the mean square torque of any coefficients.
        questions: What is open.
    """

    search: SearchResult
    suspects: tuple[Answer, ...]
    gram: np.ndarray
    right: np.ndarray
    precision: np.ndarray
    mean: np.ndarray
    weight: np.ndarray
    reaches: np.ndarray
    questions: tuple[Question, ...] = ()

    @cached_property
    def reach(self) -> np.ndarray:
        """The same over all of them, shape (c, c)."""
        return np.asarray(self.reaches.mean(axis=0))

    @property
    def unknowns(self) -> int:
        """Number of unknowns that are in the model already."""
        return len(self.search.prediction.rows.names)

    @property
    def places(self) -> list[np.ndarray]:
        """Columns of each suspect."""
        counts = [one.columns.values.shape[2] for one in self.suspects]
        stops = self.unknowns + np.cumsum([0, *counts])
        return [np.arange(a, b) for a, b in zip(stops[:-1], stops[1:], strict=True)]

    def posterior(self, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Precision (s, s) and mean (s,) of some columns (s,), all others being zero."""
        matrix = self.gram[np.ix_(which, which)] + np.diag(self.precision[which])
        right = self.right[which] + self.precision[which] * self.mean[which]
        return matrix, solve(factored(matrix), right)

    def held_by(self, question: Question, answer: Believed) -> np.ndarray:
        """Columns that are there if an answer is true, (s,); its own are the last."""
        rest = np.setdiff1d(np.arange(self.unknowns), np.concatenate([question.own, answer.places]))
        return np.concatenate([rest, answer.places]).astype(int)

    def ways(self, question: Question, answer: Believed, more: np.ndarray | None = None) -> np.ndarray:
        """What an answer changes of all coefficients, shape (c, 1 + p), beside that nothing is there.

        The change that is expected, and those by which its own p coefficients may differ from that by one
        standard deviation each; the other unknowns follow. With the products of a further run (c, c) that
        shows what is expected.
        """
        held, count = self.held_by(question, answer), len(answer.places)
        matrix, mean = self.posterior(held)
        if more is not None:
            matrix = matrix + more[np.ix_(held, held)]
        rest, own = slice(0, len(held) - count), slice(len(held) - count, None)
        followed = -solve(factored(matrix[rest, rest]), matrix[rest, own])
        apart = matrix[own, own] + matrix[own, rest] @ followed
        covariance = solve(factored(apart), np.eye(count))
        found = np.zeros((len(self.gram), 1 + count))
        spread = np.column_stack([mean[own], np.linalg.cholesky(covariance)])
        found[held] = np.concatenate([followed, np.eye(count)]) @ spread
        return found

    def stance(self, question: Question, answer: Believed) -> Stance:
        """What is believed if an answer is true."""
        held, none = self.held_by(question, answer), np.zeros((len(self.gram), 0))
        own = np.zeros(len(self.gram))
        own[answer.places] = self.mean[answer.places]
        if not len(answer.places):
            return Stance(held, self.precision[held], own, none)
        ways = np.zeros((len(self.gram), 1 + len(answer.places)))
        ways[answer.places] = self.ways(question, answer)[answer.places]
        return Stance(held, self.precision[held], own, ways)


class Suspects(NamedTuple):
    """What is not in the model and may be there.

    Attributes:
        rivals: Of what was found.
        left: What else may be there without being seen, each in its best shape.
        against: Logarithm of the odds of each finding, by its place, against effects on joints.
    """

    rivals: tuple[Answer, ...]
    left: tuple[Answer, ...]
    against: dict[int, dict[Place, float]]

    @property
    def every(self) -> tuple[Answer, ...]:
        """In the order of their columns."""
        return self.rivals + self.left


def suspects_of(search: SearchResult) -> Suspects:
    """Alternatives of the findings, and what else gives their torque; then all that was not found."""
    others = {place: rivals(search, place) for place in range(len(search.selected))}
    found = [answer for one in search.selected for answer, _ in one.elsewhere]
    found += [rival.answer for own in others.values() for rival in own]
    by_key = {one.candidate.key: one for one in reversed(found)}
    left = [
        one
        for one in search.left
        if one.candidate.key not in by_key and unseen_probability(one, search.total) >= NEGLIGIBLE
    ]
    against = {place: {_place(rival.answer): rival.odds for rival in own} for place, own in others.items()}
    return Suspects(tuple(by_key.values()), tuple(left), against)


def belief_of(
    search: SearchResult, suspects: Suspects, runs: Sequence[RunColumns], left: np.ndarray | None = None
) -> Belief:
    """The belief after a search, and what runs on offer could show.

    Args:
        search: Of the diagnosis.
        suspects: What may be there beside what was found.
        runs: On offer.
        left: Squared torque of each joint that is left without a name, shape (n,) [(N m)^2]; else none.
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
        np.min([one.columns.std, *(run.suspects[place].std for run in runs)], axis=0)
        for place, one in enumerate(suspects.left, len(suspects.rivals))
    ]
    deviation = np.maximum(np.concatenate(std), CERTAIN)
    mean = np.concatenate([prediction.rows.mean, *(one.columns.mean for one in suspects.every)])
    belief = Belief(
        search,
        suspects.every,
        products(columns, weight),
        np.einsum("rnc,rn->c", columns, weight * prediction.rows.difference),
        deviation**-2.0,
        mean,
        prediction.weighting.independent / prediction.weighting.variance,
        _reaches(search, columns, weight > 0.0, runs),
    )
    left = np.zeros(joints) if left is None else left
    asked = (*_asked(belief, suspects, left), *_unseen(belief, len(suspects.rivals)))
    return replace(belief, questions=asked)


def products(columns: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Products of columns (r, n, c) over rows and joints with a weight (r, n), shape (c, c)."""
    flat = (columns * np.sqrt(weight)[:, :, None]).reshape(-1, columns.shape[2])
    return flat.T @ flat


def all_columns(run: RunColumns, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Columns of a run, and what it brings of its own: the unknowns of a body that no run has carried so far.

    Returns:
        Columns of named unknowns and all suspects (r, n, c); of the others (r, n, e); their precision (e,).
    """
    place = {name: k for k, name in enumerate(run.rows.names)}
    known = run.rows.columns[:, :, [place[name] for name in names]]
    joints = known.shape[1]
    every = np.concatenate([known, *(one.everywhere(joints) for one in run.suspects)], axis=2)
    more = [k for name, k in place.items() if name not in set(names)]
    return every, run.rows.columns[:, :, more], np.maximum(run.rows.std[more], CERTAIN) ** -2.0


def _reaches(
    search: SearchResult, columns: np.ndarray, counts: np.ndarray, runs: Sequence[RunColumns]
) -> np.ndarray:
    """As in `Belief`: the resolution is a share of the largest usual torque of each joint."""
    names = search.prediction.rows.names
    torque = np.concatenate([run.thinned(run.torque) for run in search.problem.runs])
    parts = [(columns, counts, torque)]
    parts += [(all_columns(run, names)[0], run.rows.weight > 0.0, run.torque) for run in runs]
    usual = np.sqrt(np.max([np.mean(torque**2, axis=0) for _, _, torque in parts], axis=0))
    resolution = LINEAR * np.maximum(usual, 1e-9)
    return np.array([products(own, seen / resolution**2 / max(len(own), 1)) for own, seen, _ in parts])


def _asked(belief: Belief, suspects: Suspects, left: np.ndarray) -> Iterator[Question]:
    """A question for each finding: whether it is that, what else it may be, or nothing.

    The blocks cannot say more against another answer than the torque, to within what formulas are wrong by;
    nor more against nothing than a name needs, before another run has confirmed it, where its formula is
    refused, or where more is left that has no name than it explains.
    """
    columns = dict(zip(map(_place, suspects.rivals), belief.places, strict=False))
    for place, one in enumerate(belief.search.selected):
        if one.once:
            continue  # it is in no other run
        own, here = places_of(belief.search, place), _place(one.answer)
        weights = {_place(other): probability for other, probability in one.elsewhere}
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


def _place(one: Answer) -> Place:
    return one.candidate.effect, one.candidate.joints


def _unseen(belief: Belief, first: int) -> Iterator[Question]:
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


def unseen_probability(one: Answer, total: float) -> float:
    """That an effect which was not found is there; zero where runs held out exclude it."""
    if one.held_out < -CERTAIN_ODDS:
        return 0.0
    return float(expit(min(one.gain, one.odds, 0.0) + log_prior(one, total)))


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
